"""Camera tracking without mapping: the trajectory of a recording, its errors, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from rich.console import Console

from app.console.progress import show_progress
from app.console.waiting import waiting_for
from app.frames.frame_account import FrameAccount, SkippedFrame
from app.frames.open_recording import require_poses
from app.frames.selection import selected_frames
from app.pipeline.interrupt import StopRequest
from app.pipeline.picture_rate import is_sparse, require_estimated
from app.pipeline.sparse_pictures import match_pictures, pace, print_matched
from app.run_folder.pose_corrections import PoseCorrections
from app.settings.run_config import RunConfig
from data_tools.recordings.sequence import RgbdSequence
from data_tools.recordings.trajectories import tum_text
from razer.arrays import Float64Array
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame
from razer.metrics.scene_pair import TimedPoses
from razer.metrics.trajectory_errors import trajectory_metrics
from slam.poses import Pose
from slam.refinement import RefinedPoses
from slam.report import OpenStretch
from slam.sparse.limits import has_failed
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem

ERRORS = ("ate_rmse_m", "rotation_rmse_deg", "rpe_trans_m", "rpe_rot_deg", "aligned_by", "degenerate")


@dataclass
class TrackedPath:
    """Poses by frame index: final (smoothed) and live (as known at the frame), and given ones where there are any;
    stamps of all frames that could be used; skipped, the others; n_asked, how many were asked for; ms for each
    frame; refined, whether the final poses are the given ones, corrected; open, stretches in which a direction was."""

    n_asked: int
    stamps: dict[int, float] = field(default_factory=dict)
    live: dict[int, Pose] = field(default_factory=dict)
    final: Mapping[int, Pose] = field(default_factory=dict)
    given: dict[int, Pose] = field(default_factory=dict)
    skipped: list[SkippedFrame] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)
    n_keyframes: int = 0
    n_loops: int = 0
    interrupted: bool = False
    refined: bool = False
    open: tuple[OpenStretch, ...] = ()

    def see(self, frame: Frame) -> None:
        """Take in a frame that can be used."""
        self.stamps[frame.index] = frame.stamp
        if frame.world_from_camera is not None:
            self.given[frame.index] = frame.world_from_camera

    def as_json(self) -> dict[str, Any]:
        """The contract of `razer track --json`; errors are null where the recording brings no poses."""
        median, p95 = np.percentile(self.ms, [50, 95]) if self.ms else (0.0, 0.0)
        return {
            **self.account().as_json(),
            "interrupted": self.interrupted,
            "keyframes": self.n_keyframes,
            "loops": self.n_loops,
            "open": [stretch.describe() for stretch in self.open],
            "ms_median": round(float(median), 1),
            "ms_p95": round(float(p95), 1),
            **self._errors(),
            **({} if (corrections := self.corrections()) is None else {"corrected": corrections.as_json()}),
        }

    def tum_text(self, poses: Mapping[int, Pose]) -> str:
        """Lines of a TUM file of some of the poses, by frame index."""
        return tum_text([self.stamps[index] for index in poses], list(poses.values()))

    def corrections(self) -> PoseCorrections | None:
        """What was corrected of given poses, None where these were not to be."""
        return PoseCorrections.of(self.given, self.final) if self.refined else None

    def account(self) -> FrameAccount:
        """What became of the frames, by the final poses."""
        lost = self.stamps.keys() - self.final.keys()
        return FrameAccount.of(self.n_asked, sorted(self.final), self.skipped, lost)

    def _errors(self) -> dict[str, float | str | None]:
        numbers = None
        if self.given and self.final:
            numbers = trajectory_metrics(self._timed(self.given), self._timed(self.final))
        if numbers is None:
            return dict.fromkeys(ERRORS)
        rpe, alignment = numbers.per_frame, numbers.by_positions
        values = {
            "ate_rmse_m": numbers.ate_rmse_m,
            "rotation_rmse_deg": numbers.rotation_rmse_deg,
            "rpe_trans_m": rpe.translation_m,
            "rpe_rot_deg": rpe.rotation_deg,
        }
        finite = {name: value if np.isfinite(value) else None for name, value in values.items()}
        return finite | {"aligned_by": alignment.basis, "degenerate": alignment.degenerate}

    def _timed(self, poses: Mapping[int, Pose]) -> TimedPoses:
        stamps: Float64Array = np.array([self.stamps[index] for index in poses])
        order = np.argsort(stamps, kind="stable")
        rows = order[np.concatenate([[True], np.diff(stamps[order]) > 0])]
        return TimedPoses(stamps[rows], np.stack(list(poses.values()))[rows], len(self.stamps))


def tracked_path(sequence: RgbdSequence, config: RunConfig, console: Console) -> TrackedPath:
    """Locate the frames that the settings choose, with progress shown; raises BadInput where none can be."""
    indices, settings = selected_frames(sequence, config.input), config.input
    if settings.poses == "refine":
        require_estimated(settings.poses, settings.sparse)
    elif is_sparse(sequence, indices, settings):
        path, system = _matched(sequence, indices, config, console)
        print_matched(system, pace(sequence, indices), console)
        return _with_any(path, sequence)
    path = _followed(sequence, indices, config, console)
    may_match = settings.poses != "refine" and settings.sparse is None and not path.interrupted
    if may_match and has_failed(len(path.stamps) - len(path.final), len(indices)):
        n_before = len(path.final)
        matched, system = _matched(sequence, indices, config, console)
        if len(matched.final) > n_before:
            print_matched(system, f"following the camera located {n_before} of {len(indices)}: ", console)
            path = matched
    return _with_any(path, sequence)


def _with_any(path: TrackedPath, sequence: RgbdSequence) -> TrackedPath:
    if not path.final and not path.interrupted:
        raise BadInput(f"{sequence.name}: the camera could not be located in any frame")
    return path


def _matched(
    sequence: RgbdSequence, indices: Sequence[int], config: RunConfig, console: Console
) -> tuple[TrackedPath, SparseSystem]:
    """The path by matching all pictures at once; what that took is shared out among them."""
    path, start_s = TrackedPath(len(indices)), perf_counter()

    def skip(index: int, reason: str) -> None:
        path.skipped.append(SkippedFrame(index, reason))

    system = match_pictures(sequence, indices, config.slam, console, path.see, skip)
    path.ms = [1e3 * (perf_counter() - start_s) / max(len(path.stamps), 1)] * len(path.stamps)
    path.final = system.trajectory()
    path.n_keyframes, path.n_loops = len(system.keyframes), system.n_loops
    return path, system


def _followed(sequence: RgbdSequence, indices: Sequence[int], config: RunConfig, console: Console) -> TrackedPath:
    path, slam = TrackedPath(len(indices), refined=config.input.poses == "refine"), _estimation(sequence, config)
    with StopRequest() as stop:
        for index in show_progress(indices, len(indices), lambda: f"{len(path.stamps) - len(path.live)} lost", console):
            if stop.requested:
                path.interrupted = True
                break
            try:
                _locate(sequence[index], slam, path)
            except UnusableFrame as error:
                path.skipped.append(SkippedFrame(index, str(error)))
                console.print(f"skipped frame {index}: {error}", soft_wrap=True)
    with waiting_for("smoothing the path", console):
        slam.finish()
    path.final = slam.trajectory()
    path.open = () if (graph := slam.report().graph) is None else graph.open
    path.n_keyframes, path.n_loops = len(slam.keyframes), slam.n_loops
    return path


def _estimation(sequence: RgbdSequence, config: RunConfig) -> SlamSystem | RefinedPoses:
    if config.input.poses != "refine":
        return SlamSystem(config.slam)
    require_poses(sequence)
    return RefinedPoses(config.slam)


def _locate(frame: Frame, slam: SlamSystem | RefinedPoses, path: TrackedPath) -> None:
    start_s = perf_counter()
    pose = slam.locate(frame)
    path.see(frame)
    path.ms.append(1e3 * (perf_counter() - start_s))
    if pose is not None:
        path.live[frame.index] = pose
