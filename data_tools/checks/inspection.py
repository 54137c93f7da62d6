"""Inspection of a recording: statistics over a few of its frames, and likely mistakes in how it was made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_tools.calibration.rgbd_estimate import RgbdEstimate, estimate_rgbd_calibration
from data_tools.checks.depth_scale import DepthScaleReport, check_depth_scale
from data_tools.checks.pose_check import NO_CONVENTION, PoseCheck, check_poses, convention_fix
from data_tools.checks.rgbd_alignment_check import RgbdAlignmentReport, check_rgbd_alignment
from data_tools.checks.sample import Sample
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics

_N_FRAMES = 40
_MANY_BAD = 0.3
_MIRRORED = "left-handed"
_TO_DECLARE = (
    "record more of the place; or say where the colour camera is, with --rgbd-calibration FILE.json, or with its "
    'intrinsics as "color" in --intrinsics FILE.json and --depth-to-color FILE'
)


@dataclass(frozen=True, slots=True)
class Issue:
    """One likely mistake: what it is about ("poses", "depth scale", "registration", "intrinsics" or "frames"), what is
    seen, and the likely fix, a plain line each."""

    about: str
    problem: str
    fix: str


@dataclass(frozen=True, slots=True)
class DepthStatistics:
    """The 5th, 50th and 95th percentile of the readings, metres, and the share of the pixels with a reading."""

    low_m: float
    median_m: float
    high_m: float
    valid: float


@dataclass(frozen=True, slots=True)
class Inspection:
    """The result; `inspected` frames were read for it: `bad` (index, reason) could not be used, `posed` have a
    pose. rate_hz and duration_s by the stamps, path_m along those poses; None = not known."""

    name: str
    n_frames: int
    intrinsics: Intrinsics
    inspected: int
    posed: int
    bad: tuple[tuple[int, str], ...]
    rate_hz: float | None
    duration_s: float | None
    path_m: float | None
    depth: DepthStatistics | None
    depth_scale: DepthScaleReport
    poses: PoseCheck
    rgbd_alignment: RgbdAlignmentReport
    rgbd_estimate: RgbdEstimate
    issues: tuple[Issue, ...]


def inspect_sequence(sequence: RgbdSequence) -> Inspection:
    """Look at about sixty frames of a recording; takes a few seconds."""
    usable, bad = _read_spread(sequence)
    sample = Sample.of(sequence)
    poses = check_poses(sample)
    depth_scale = check_depth_scale(sequence, sample.reposed(poses.convention) if poses.wrong else sample)
    rgbd_alignment = check_rgbd_alignment(sample.frames)
    rgbd_estimate = estimate_rgbd_calibration(sequence)
    posed = [frame for frame in usable if frame.world_from_camera is not None]
    issues = [
        *_frame_issues(bad, len(usable) + len(bad)),
        *_pose_issues(poses, depth_scale, sequence),
        *_scale_issues(depth_scale),
        *_alignment_issues(rgbd_alignment, rgbd_estimate),
    ]
    return Inspection(
        name=sequence.name,
        n_frames=len(sequence),
        intrinsics=sequence.intrinsics,
        inspected=len(usable) + len(bad),
        posed=len(posed),
        bad=tuple(bad),
        rate_hz=_rate_hz(sample),
        duration_s=usable[-1].stamp - usable[0].stamp if usable else None,
        path_m=_path_m(posed),
        depth=_depth_statistics(usable),
        depth_scale=depth_scale,
        poses=poses,
        rgbd_alignment=rgbd_alignment,
        rgbd_estimate=rgbd_estimate,
        issues=tuple(issues),
    )


def _read_spread(sequence: RgbdSequence) -> tuple[list[Frame], list[tuple[int, str]]]:
    """Frames spread over all of the recording, and which of them cannot be used."""
    usable: list[Frame] = []
    bad: list[tuple[int, str]] = []
    for index in dict.fromkeys(np.linspace(0, len(sequence) - 1, _N_FRAMES).round().astype(int).tolist()):
        try:
            usable.append(sequence[index])
        except UnusableFrame as error:
            bad.append((index, str(error)))
    return usable, bad


def _frame_issues(bad: Sequence[tuple[int, str]], inspected: int) -> list[Issue]:
    # File names and numbers differ from frame to frame; what is wrong with them is said after.
    reasons = Counter(reason.rpartition(": ")[2] for _, reason in bad)
    if len(bad) < _MANY_BAD * inspected:
        return []
    reason, count = reasons.most_common(1)[0]
    problem = f"{len(bad)} of {inspected} frames cannot be used; the commonest reason ({count} times): {reason}"
    if _MIRRORED in reason:
        return [Issue("poses", problem, "an axis of the camera is flipped: negate one column of each rotation")]
    return [Issue("frames", problem, "repair or remove them; frames that can be used are mapped without them")]


def _pose_issues(report: PoseCheck, depth_scale: DepthScaleReport, sequence: RgbdSequence) -> list[Issue]:
    if report.is_unfit and depth_scale.verdict == "ok":
        return [Issue("poses", report.contradiction, NO_CONVENTION)]
    if not report.wrong:
        return []
    (depth_now, depth_fixed), (px_now, px_fixed) = report.agreement, report.error_px
    problem = f"moved by the poses, {depth_now:.0%} of the depth agrees between frames, {depth_fixed:.0%} after the fix"
    if np.isfinite(px_now):
        problem += f"; features are missed by {px_now:.0f} pixels, then {px_fixed:.0f}"
    return [Issue("poses", problem, convention_fix(report, sequence))]


def _scale_issues(report: DepthScaleReport) -> list[Issue]:
    if report.verdict == "ok":
        return []
    problem = f"the depth scale of {report.declared:g} units per metre looks wrong: {report.reason}"
    return [Issue("depth scale", problem, report.advice)]


def _alignment_issues(report: RgbdAlignmentReport, estimate: RgbdEstimate) -> list[Issue]:
    if report.wrong and report.mirrored:
        fix = "flip the colour or the depth images left to right"
        return [Issue("registration", "colour and depth are mirror images of each other", fix)]
    if estimate.matters and estimate.may_be_far_off:
        return [Issue("registration", f"colour and depth are not registered: {estimate}", _remedy(estimate))]
    if not estimate.confident and (report.wrong or estimate.may_be_far_off):
        problem = f"colour and depth seem not to be registered, but by how much cannot be told: {estimate.reason}"
        return [Issue("registration", problem, _TO_DECLARE)]
    return []


def _remedy(estimate: RgbdEstimate) -> str:
    color = estimate.calibration.color
    camera = f"fx {color.fx:.1f}, fy {color.fy:.1f}, cx {color.cx:.1f}, cy {color.cy:.1f}"
    return (
        f"none is needed, `razer run` brings colour onto depth by itself; --write FILE.json writes the colour camera "
        f"({camera}, and where it stands) for `razer run --rgbd-calibration FILE.json`"
    )


def _rate_hz(sample: Sample) -> float | None:
    steps = [b.stamp - a.stamp for a, b in sample.starts() if b.index == a.index + 1]
    return 1 / float(np.median(steps)) if steps and np.median(steps) > 0 else None


def _path_m(posed: Sequence[Frame]) -> float | None:
    if not posed:
        return None
    positions = np.array([frame.pose[:3, 3] for frame in posed])
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def _depth_statistics(frames: Sequence[Frame]) -> DepthStatistics | None:
    readings = [frame.depth[::4, ::4] for frame in frames]
    valid = np.concatenate([depth[depth > 0] for depth in readings]) if readings else np.zeros(0, np.float32)
    if not len(valid):
        return None
    low, median, high = np.quantile(valid, (0.05, 0.5, 0.95)).tolist()
    return DepthStatistics(low, median, high, len(valid) / sum(depth.size for depth in readings))
