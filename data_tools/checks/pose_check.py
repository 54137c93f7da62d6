"""Check of the pose convention: camera to world, x right, y down, z forward, or another one.

Two measures over pairs of nearby frames: the reprojection error of matched features, and how much of the one frame's
depth lies on the depth of the other. Another convention is named only if it does clearly better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_tools.checks.camera_motion import Motion
from data_tools.checks.depth_overlap import clearly_better, depth_agreement, overlapping_only
from data_tools.checks.pose_conventions import AS_WRITTEN, N_COMMON, Convention, conventions
from data_tools.checks.sample import Sample
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Float64Array
from razer.frame import Frame
from razer.geometry import inverse, project, transform_points

_MIN_PAIRS = 4
_POINTS = 40
# Depth may be wrong too: each convention is judged at the scale that suits it best.
_FACTORS = np.array([1.0, 5.0, 0.2, 10.0, 0.1, 1000.0, 0.001])
_SUSPICIOUS = 0.012  # median error of features, share of the image's width
# The same, from which on the poses do not fit, by any convention: with 4 cm of noise of each it is half of that, and
# poses of another recording, or backwards, are beyond it.
_UNFIT = 0.03
_CLEARLY_BETTER = 0.4
_TIE = 1.3
NO_CONVENTION = (
    "no convention explains it: see whether they are of this recording, in its order and by its clock, and whether the "
    "intrinsics are right; --poses slam needs none"
)


@dataclass(frozen=True, slots=True)
class PoseCheck:
    """What the poses seem to be: the convention, AS_WRITTEN if nothing is clearly better or nothing can be told;
    pairs of frames judged; for the poses as written and as meant, the median error of features (pixels) and the
    share of depth that agrees; is_unfit, whether images contradict the poses and no convention explains it."""

    convention: Convention
    n_pairs: int
    error_px: tuple[float, float] = (float("nan"), float("nan"))
    agreement: tuple[float, float] = (float("nan"), float("nan"))
    is_unfit: bool = False

    @property
    def contradiction(self) -> str:
        """What speaks against the poses as they are meant, in plain words."""
        return (
            f"moved by the poses, {self.agreement[1]:.0%} of the depth agrees between frames, and features are missed "
            f"by {self.error_px[1]:.0f} pixels"
        )

    @property
    def wrong(self) -> bool:
        """Whether another convention fits clearly better."""
        return self.convention is not AS_WRITTEN


def check_poses(sample: Sample) -> PoseCheck:
    """Judge the convention of the poses; takes about a second."""
    if not sample.has_poses:
        return PoseCheck(AS_WRITTEN, 0)
    measured = [(a, b, motion) for a, b in sample.neighbours() if (motion := sample.motion(a, b))]
    if len(measured) < _MIN_PAIRS:
        return _judge_by_depth(list(sample.neighbours()))
    (error,), (factor,) = _reprojection_errors(measured, (AS_WRITTEN,))
    agreement = _agreement(measured, AS_WRITTEN, factor)
    if error <= _SUSPICIOUS * measured[0][0].intrinsics.width:
        return PoseCheck(AS_WRITTEN, len(measured), (error, error), (agreement, agreement))
    meant, best_error_px, better = _best(measured)
    if best_error_px > _CLEARLY_BETTER * error or better <= agreement:
        meant, best_error_px, better = AS_WRITTEN, error, agreement
    is_unfit = best_error_px > _UNFIT * measured[0][0].intrinsics.width
    return PoseCheck(meant, len(measured), (error, best_error_px), (agreement, better), is_unfit)


def convention_fix(report: PoseCheck, sequence: RgbdSequence) -> str:
    """What to do about poses of another convention. Of a file that stands for the recording's own they were read as its
    kind defines them, so that the file is not what it seems."""
    if not getattr(sequence, "poses_note", ""):
        return report.convention.fix
    return f"read as its kind has them, {report.convention.fix}; so the file was not written as that kind is"


def _best(pairs: Sequence[tuple[Frame, Frame, Motion]]) -> tuple[Convention, float, float]:
    """The convention that fits best, the first, so commonest, of those that cannot be told apart; its median error in
    pixels, and its agreement of depth."""
    errors, factors = _reprojection_errors(pairs, conventions())
    i = next(i for i, error in enumerate(errors) if error <= _TIE * min(errors))
    return conventions()[i], errors[i], _agreement(pairs, conventions()[i], factors[i])


def _judge_by_depth(pairs: Sequence[tuple[Frame, Frame]]) -> PoseCheck:
    """The verdict where images show no motion: only the commonest mistakes, and only if depth then fits."""
    if not pairs:
        return PoseCheck(AS_WRITTEN, 0)
    common = conventions()[:N_COMMON]
    agreements = overlapping_only(
        np.array([[depth_agreement(a, b, _moved(each, a, b)) for each in common] for a, b in pairs])
    )
    if not len(agreements):
        return PoseCheck(AS_WRITTEN, 0)
    best = clearly_better(agreements)
    means = agreements.mean(axis=0)
    return PoseCheck(common[best], len(agreements), agreement=(float(means[0]), float(means[best])))


def _reprojection_errors(
    pairs: Sequence[tuple[Frame, Frame, Motion]], every: Sequence[Convention]
) -> tuple[list[float], list[float]]:
    """For each convention the median over pairs of the median distance, pixels, between where b should see a's
    features and where it does, at the depth factor that suits best; and that factor."""
    errors = np.array(
        [[_reprojection_error(_moved(convention, a, b), a, motion) for convention in every] for a, b, motion in pairs]
    )
    typical = np.median(errors, axis=0)
    return typical.min(axis=1).tolist(), _FACTORS[typical.argmin(axis=1)].tolist()


def _moved(convention: Convention, a: Frame, b: Frame) -> Float64Array:
    """b_from_a by the convention."""
    return inverse(convention.world_from_camera(b.pose)) @ convention.world_from_camera(a.pose)


def _reprojection_error(b_from_a: Float64Array, a: Frame, motion: Motion) -> Float64Array:
    """The median distance in pixels, cut off at the image's width, at each of _FACTORS."""
    points, pixels = motion.points[:_POINTS], motion.pixels[:_POINTS]
    scaled = points * _FACTORS[:, None, None]
    u, v, _ = project(transform_points(b_from_a, scaled), a.intrinsics.matrix)
    distance = np.hypot(u - pixels[:, 0], v - pixels[:, 1])
    width = a.intrinsics.width
    return np.median(np.nan_to_num(distance, nan=width).clip(0, width), axis=1)


def _agreement(pairs: Sequence[tuple[Frame, Frame, Motion]], convention: Convention, factor: float) -> float:
    """Mean share of a's depth that is moved onto b's depth."""
    return float(np.mean([depth_agreement(a, b, _moved(convention, a, b), factor) for a, b, _ in pairs]))
