"""A finished run, read back: its map and its trajectory."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.run_folder import run_folder as names
from app.run_folder.timed_poses import timed_poses
from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.geometry import transform_points
from razer.metrics.scene_pair import TimedPoses
from razer.panoptic_map import PanopticMap
from razer.saved_map import load_map


@dataclass(frozen=True)
class MappedRun:
    """The map of a run and its trajectory, both in the same frame; name, that of its folder. A saved map has no
    trajectory."""

    name: str
    panoptic: PanopticMap
    trajectory: TimedPoses | None

    @property
    def tracked(self) -> float | None:
        """The share of the frames the run looked at that have a pose; None where it did not count them."""
        if self.trajectory is None or not self.trajectory.n_frames:
            return None
        return len(self.trajectory.stamps) / self.trajectory.n_frames

    def moved(self, target_from_own: Float64Array) -> MappedRun:
        """The same run in another frame."""
        mesh = self.panoptic.mesh
        vertices = transform_points(target_from_own, mesh.vertices.astype(np.float64)).astype(np.float32)
        objects = tuple(replace(o, box=_moved_box(target_from_own, o.box)) for o in self.panoptic.objects)
        up = None if self.panoptic.up is None else target_from_own[:3, :3] @ self.panoptic.up
        panoptic = PanopticMap(objects, replace(mesh, vertices=vertices), up=up)
        trajectory = self.trajectory
        return MappedRun(self.name, panoptic, None if trajectory is None else moved_poses(target_from_own, trajectory))


def moved_poses(target_from_own: Float64Array, trajectory: TimedPoses) -> TimedPoses:
    """A trajectory in another frame."""
    return replace(trajectory, world_from_camera=target_from_own @ trajectory.world_from_camera)


def _moved_box(target_from_own: Float64Array, box: OrientedBox) -> OrientedBox:
    rotation = target_from_own[:3, :3] @ box.rotation
    return OrientedBox(transform_points(target_from_own, box.center), rotation, box.extent)


def read_run(folder: Path) -> MappedRun:
    """What a run left; raises BadInput naming what is missing or broken."""
    return MappedRun(folder.absolute().name, load_map(folder), _trajectory(folder))


def _trajectory(folder: Path) -> TimedPoses | None:
    path = folder / names.TRAJECTORY
    if not path.is_file():
        return None
    poses = timed_poses(path)
    return replace(poses, n_frames=_frames_looked_at(folder, len(poses.stamps)))


def _frames_looked_at(folder: Path, n_poses: int) -> int | None:
    """How many frames a run looked at, with those it could not locate, as its timings say."""
    try:
        frames = int(json.loads((folder / names.TIMINGS).read_text())["frames"])
    except (OSError, KeyError, ValueError, TypeError):
        return None
    return frames if frames >= n_poses else None
