"""Second attempt: where following the camera through a short recording failed, its pictures are matched all at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Pose
from razer.errors import UnusableFrame
from slam.config import SlamConfig
from slam.sparse.limits import has_failed
from slam.sparse.solved_poses import SolvedPoses


@dataclass(frozen=True)
class SecondAttempt:
    """Matches the frames `indices` of a recording with each other; travels to the process that locates frames."""

    sequence: RgbdSequence
    indices: Sequence[int]
    config: SlamConfig

    def __call__(self, n_lost: int) -> tuple[SolvedPoses, dict[int, Pose | None], str] | None:
        """The poses, those of all frames that can be used with None for what is lost, and one line that says what was
        done and why; None where nothing failed or nothing is better for it. n_lost: by following the camera, of the
        frames that can be used."""
        if not has_failed(n_lost, len(self.indices)):
            return None
        from slam.sparse.sparse_system import SparseSystem

        system, n_usable = SparseSystem(self.config), 0
        for index in self.indices:
            try:
                system.locate(self.sequence[index])
            except UnusableFrame:
                continue
            n_usable += 1
        system.finish()
        poses, n_located = system.trajectory(), n_usable - n_lost
        if len(poses) <= n_located:
            return None
        seen = {keyframe.view.index: poses.get(keyframe.view.index) for keyframe in system.keyframes.all}
        note = (
            f"following the camera located {n_located} of {len(self.indices)} frames: all were matched with each other "
            f"instead, {len(poses)} located; --no-sparse leaves it at the first"
        )
        return SolvedPoses.of(system), seen, note
