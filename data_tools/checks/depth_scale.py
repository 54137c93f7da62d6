"""Check of the declared depth scale, and which one is likely if it is wrong.

Evidence, strongest first: how far the camera moved according to images and depth against how far according to
the poses (reprojection), or where images show no motion, whether depths of two frames agree once moved; the steps
between depth readings, which a structured-light sensor's geometry fixes; and whether the median depth is one that
an indoor camera sees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from data_tools.checks.depth_overlap import clearly_better, depth_agreement, overlapping_only
from data_tools.checks.sample import Sample
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Float64Array
from razer.frame import Frame
from razer.geometry import inverse

SUSPICIOUS_FACTOR = 2.2  # sqrt(5): half way, in ratio, to the nearest common mistake
MIN_MEDIAN_M, MAX_MEDIAN_M = 0.15, 20.0
TYPICAL_MEDIAN_M = 2.0
# Units per metre in use, commonest first: mm, TUM, m, 1/10 mm, cm, Replica as rendered for NICE-SLAM.
KNOWN_SCALES = (1000.0, 5000.0, 1.0, 10000.0, 100.0, 6553.5)

_PAIRS_PER_START = 4
_MAX_TURN_DEG = 30.0
_MIN_PAIRS = 5
_MIN_MOTION_SIGMA = 5.0
_MIN_EXPLAINED = 0.5
_MAX_MOTION_SPREAD = 10.0  # pairs that differ by an order of magnitude say nothing
_DISPARITY_STEP_PER_M = 1 / (8 * 580 * 0.075)  # Kinect, Xtion, Structure: 1/8 pixel, focal length, baseline
_MIN_STEP_UNITS, _MIN_STEPS = 4, 40
_MAX_STEP_SPREAD = 0.35
_LIKELY_TOLERANCE = 1.2


@dataclass(frozen=True, slots=True)
class DepthScaleReport:
    """The verdict on the declared scale; `likely` is the scale to try instead, units per metre; `reason` is
    one plain sentence."""

    verdict: Literal["ok", "suspicious"]
    declared: float
    likely: float | None
    reason: str

    @property
    def advice(self) -> str:
        """What to do about a suspicious scale."""
        return f"try --depth-scale {self.likely:g}" if self.likely else "give the right one with --depth-scale"


@dataclass(frozen=True, slots=True)
class Estimate:
    """By which factor depths should be multiplied: median and central 68 % of what was measured."""

    factor: float
    low: float
    high: float

    @property
    def contradicts(self) -> bool:
        """Whether a factor of 1 is out of the question."""
        too_small = self.factor > SUSPICIOUS_FACTOR and self.low > 1
        too_large = self.factor < 1 / SUSPICIOUS_FACTOR and self.high < 1
        return too_small or too_large


def check_depth_scale(sequence: RgbdSequence, sample: Sample | None = None) -> DepthScaleReport:
    """Judge the declared depth scale from a few frames of a recording; takes about a second."""
    sample = sample or Sample.of(sequence)
    frames = sample.frames
    if not frames:
        return DepthScaleReport("ok", sequence.depth_scale, None, "no usable frame to judge by")
    moved, steps = factor_from_motion(sample), factor_from_steps(frames)
    median_m = float(np.median([np.median(frame.depth[frame.depth > 0]) for frame in frames]))
    if moved is None and (likely := _scale_by_overlap(sample, sequence.depth_scale)):
        reason = "moved by the poses, depths of two frames agree only at another scale"
        return DepthScaleReport("suspicious", sequence.depth_scale, likely, reason)
    return _judge(sequence.depth_scale, moved, steps, median_m)


def _judge(declared: float, moved: Estimate | None, steps: Estimate | None, median_m: float) -> DepthScaleReport:
    median_text = f"the median depth is {median_m:.3g} m"
    if moved:
        return _judge_by_motion(declared, moved, steps, median_text)
    if steps and steps.contradicts and (stepped := _known_scale(declared / steps.factor)):
        reason = f"the steps between depth readings fit a structured-light camera at another scale; {median_text}"
        return DepthScaleReport("suspicious", declared, stepped, reason)
    if not MIN_MEDIAN_M <= median_m <= MAX_MEDIAN_M:
        guess = _plausible_scale(declared * median_m)
        return DepthScaleReport("suspicious", declared, guess, f"{median_text}, which no room is")
    return DepthScaleReport("ok", declared, None, f"{median_text}; no motion to measure it by")


def _judge_by_motion(declared: float, moved: Estimate, steps: Estimate | None, median_text: str) -> DepthScaleReport:
    if not moved.contradicts:
        return DepthScaleReport("ok", declared, None, "depth agrees with the motion of the poses")
    reason = f"images and depth show {1 / moved.factor:.2g} times the motion that the poses claim; {median_text}"
    if steps and abs(np.log(steps.factor)) < np.log(_LIKELY_TOLERANCE):
        reason += "; the steps between depth readings fit, so perhaps the poses are not in metres"
        return DepthScaleReport("suspicious", declared, None, reason)
    return DepthScaleReport("suspicious", declared, _likely_scale(declared, moved), reason)


def factor_from_motion(sample: Sample) -> Estimate | None:
    """The factor at which the translations measured by images and depth are those of the poses, over pairs of
    frames within each stretch; None where motion or agreement is too small to tell."""
    if not sample.has_poses:
        return None
    rows = [row for group in sample.groups for row in _translation_ratios(sample, group)]
    clear = np.array([row for row in rows if row[3] >= _MIN_MOTION_SIGMA])
    if len(clear) < _MIN_PAIRS:
        return None
    share, weight, residual, total = clear.T
    low, middle, high = _weighted_quantiles(share, weight)
    if middle <= 0 or np.sum(residual**2) > (1 - _MIN_EXPLAINED) * np.sum(total**2):
        return None
    if low * _MAX_MOTION_SPREAD < high:
        return None
    return Estimate(1 / middle, 1 / high, 1 / low)


def _scale_by_overlap(sample: Sample, declared: float) -> float | None:
    """The known scale at which depths agree clearly better between posed frames than at the declared one."""
    pairs = list(sample.neighbours()) if sample.has_poses else []
    if not pairs:
        return None
    scales = (declared, *KNOWN_SCALES)
    agreements = [
        [depth_agreement(a, b, inverse(b.pose) @ a.pose, declared / scale) for scale in scales] for a, b in pairs
    ]
    best = clearly_better(overlapping_only(np.array(agreements)))
    return scales[best] if best else None


def factor_from_steps(frames: Sequence[Frame]) -> Estimate | None:
    """The factor at which the steps between depth readings are those of a structured-light camera, which reads
    disparity in 1/8 pixel: dz = z^2 / (8 f b); None where depth is not stepped like that."""
    values = np.unique(np.concatenate([frame.depth[frame.depth > 0] for frame in frames])).astype(np.float64)
    gaps = np.diff(values)
    if len(gaps) < _MIN_STEPS:
        return None
    wide = gaps >= _MIN_STEP_UNITS * gaps.min()  # narrower ones are rounded beyond use
    steps = gaps[wide] / (values[:-1] * values[1:])[wide]
    if wide.sum() < _MIN_STEPS:
        return None
    low, middle, high = np.quantile(steps, (0.16, 0.5, 0.84)) / _DISPARITY_STEP_PER_M
    if high - low > 2 * _MAX_STEP_SPREAD * middle:
        return None
    return Estimate(float(middle), float(low), float(high))


def _translation_ratios(sample: Sample, group: Sequence[Frame]) -> list[tuple[float, float, float, float]]:
    """For the pairs of frames that moved most: the share s of the declared translation t that fits the
    measured m, its weight, and in standard deviations what is left, |m - s t|, of |m|."""
    rows = []
    for a, b, declared in _moving_pairs(group):
        measured = sample.motion(a, b)
        if measured is None:
            continue
        weight = measured.length(declared)
        share = float(declared @ measured.information @ measured.translation) / weight**2
        residual = measured.length(measured.translation - share * declared)
        rows.append((share, weight, residual, measured.length(measured.translation)))
    return rows


def _moving_pairs(group: Sequence[Frame]) -> list[tuple[Frame, Frame, Float64Array]]:
    """Frames (a, b) and the declared translation of b_from_a, longest first, without wide turns."""
    pairs = []
    for a, b in combinations(group, 2):
        motion = inverse(b.pose) @ a.pose
        turn_deg = np.degrees(np.arccos(np.clip((np.trace(motion[:3, :3]) - 1) / 2, -1, 1)))
        if turn_deg <= _MAX_TURN_DEG and motion[:3, 3].any():
            pairs.append((a, b, motion[:3, 3]))
    return sorted(pairs, key=lambda pair: -float(np.linalg.norm(pair[2])))[:_PAIRS_PER_START]


def _likely_scale(declared: float, estimate: Estimate) -> float:
    """The commonest known scale that the estimate allows, else what it says to two digits."""
    spread = float(np.sqrt(estimate.high / estimate.low))
    tolerance = float(np.clip(spread, _LIKELY_TOLERANCE, SUSPICIOUS_FACTOR))
    measured = declared / estimate.factor
    return _known_scale(measured, tolerance) or float(f"{measured:.2g}")


def _known_scale(measured: float, tolerance: float = _LIKELY_TOLERANCE) -> float | None:
    near = [known for known in KNOWN_SCALES if abs(np.log(known / measured)) <= np.log(tolerance)]
    return near[0] if near else None


def _plausible_scale(median_units: float) -> float | None:
    """The known scale that makes the median depth most like that of a room; None where none does."""
    known = min(KNOWN_SCALES, key=lambda scale: abs(np.log(median_units / scale / TYPICAL_MEDIAN_M)))
    return known if MIN_MEDIAN_M <= median_units / known <= MAX_MEDIAN_M else None


def _weighted_quantiles(values: Float64Array, weights: Float64Array) -> tuple[float, float, float]:
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / weights.sum()
    low, middle, high = (values[order][np.searchsorted(share, level)] for level in (0.16, 0.5, 0.84))
    return float(low), float(middle), float(high)
