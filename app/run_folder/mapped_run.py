"""A finished run, read back: its map and its trajectory."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.console.streams import print_notes
from app.frames.frame_account import FrameAccount
from app.run_folder.pose_corrections import PoseCorrections, read_corrections
from app.run_folder.timed_poses import run_poses
from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.geometry import transform_points
from razer.metrics.scene_pair import TimedPoses
from razer.panoptic_map import PanopticMap
from razer.saved_map import load_map


@dataclass(frozen=True)
class MappedRun:
    """The map of a run and its trajectory, both in the same frame, and the account of its frames; name, that of its
    folder; what was corrected of given poses, None where they were not refined. A saved map has neither trajectory
    nor account."""

    name: str
    panoptic: PanopticMap
    trajectory: TimedPoses | None
    account: FrameAccount | None
    corrections: PoseCorrections | None = None

    @property
    def tracked(self) -> float | None:
        """The share of the frames asked for that have a pose; None where that is not known."""
        return None if self.account is None else self.account.tracked

    def moved(self, target_from_own: Float64Array) -> MappedRun:
        """The same run in another frame."""
        mesh = self.panoptic.mesh
        vertices = transform_points(target_from_own, mesh.vertices.astype(np.float64)).astype(np.float32)
        objects, parts = (
            tuple(replace(o, box=_moved_box(target_from_own, o.box)) for o in group)
            for group in (self.panoptic.objects, self.panoptic.parts)
        )
        up = None if self.panoptic.up is None else target_from_own[:3, :3] @ self.panoptic.up
        moved_mesh, vertex_parts = replace(mesh, vertices=vertices), self.panoptic.vertex_parts
        panoptic = PanopticMap(objects, moved_mesh, up=up, parts=parts, vertex_parts=vertex_parts)
        trajectory = self.trajectory
        moved = None if trajectory is None else moved_poses(target_from_own, trajectory)
        return MappedRun(self.name, panoptic, moved, self.account, self.corrections)


def moved_poses(target_from_own: Float64Array, trajectory: TimedPoses) -> TimedPoses:
    """A trajectory in another frame."""
    return replace(trajectory, world_from_camera=target_from_own @ trajectory.world_from_camera)


def _moved_box(target_from_own: Float64Array, box: OrientedBox) -> OrientedBox:
    rotation = target_from_own[:3, :3] @ box.rotation
    return OrientedBox(transform_points(target_from_own, box.center), rotation, box.extent)


def read_run(folder: Path) -> MappedRun:
    """What a run left; raises BadInput naming what is missing or broken."""
    trajectory, account = run_poses(folder) or (None, None)
    panoptic = load_map(folder)
    print_notes(panoptic.edit_problems)
    return MappedRun(folder.absolute().name, panoptic, trajectory, account, read_corrections(folder))
