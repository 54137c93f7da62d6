"""What speaks for the poses of one run or another over the same frames."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.run_folder.mapped_run import MappedRun
from razer.arrays import Float64Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.trajectory_errors import match_timestamps
from razer.metrics.umeyama import align_views

SAME_TIME_S = 0.01
ADVICE = (
    "Poses that are off draw walls and edges twice: of two maps of the same frames the one with **less surface**, "
    "fewer frames lost and sharper edges in *Overview* has the better poses. `razer compare` measures more."
)


def world_from_other(first: MappedRun, other: MappedRun) -> Float64Array:
    """The motion (4, 4) into the world of the first run, by the frames that both have a pose of; without any none."""
    ours, theirs, _ = _common(first, other)
    return align_views(theirs, ours) if len(ours) else np.eye(4)


def pose_figures(runs: Mapping[str, MappedRun]) -> str:
    """Markdown: a table of the runs, by name, and how far the second path is from the first."""
    rows = {
        "frames with a pose": [_tracked(run) for run in runs.values()],
        "walked": [f"{_length_m(run):.1f} m" for run in runs.values()],
        "objects": [f"{sum(not item.is_stuff for item in run.panoptic.objects)}" for run in runs.values()],
        "surface": [f"{surface_area_m2(run.panoptic.mesh):.1f} m²" for run in runs.values()],
    }
    table = ["| | " + " | ".join(runs) + " |", "|---|" + "--:|" * len(runs)]
    table += [f"| {name} | " + " | ".join(values) + " |" for name, values in rows.items()]
    first, second = list(runs.values())[:2]
    return "\n".join([*table, "", _apart(first, second), "", ADVICE])


def surface_area_m2(mesh: LabelledMesh) -> float:
    """The area of a mesh."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(np.float64) for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _apart(first: MappedRun, second: MappedRun) -> str:
    ours, theirs, stamps = _common(first, second)
    if not len(ours):
        return "The runs have no frame in common."
    moved = world_from_other(first, second) @ theirs
    gaps_cm = 100 * np.linalg.norm(moved[:, :3, 3] - ours[:, :3, 3], axis=1)
    farthest = f"{gaps_cm.max():.1f} cm at most (at {stamps[gaps_cm.argmax()]:.2f} s)"
    return f"The paths are {gaps_cm.mean():.1f} cm apart on average, {farthest}."


def _common(first: MappedRun, other: MappedRun) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Poses (N, 4, 4) of both at the same times, and the times (N,), seconds."""
    if first.trajectory is None or other.trajectory is None:
        return np.zeros((0, 4, 4)), np.zeros((0, 4, 4)), np.zeros(0)
    ours, theirs = match_timestamps(first.trajectory.stamps, other.trajectory.stamps, SAME_TIME_S)
    parts = first.trajectory.world_from_camera[ours], other.trajectory.world_from_camera[theirs]
    a, b, stamps = (part.astype(np.float64) for part in (*parts, first.trajectory.stamps[ours]))
    return a, b, stamps


def _tracked(run: MappedRun) -> str:
    if run.trajectory is None:
        return "not known"
    return f"{len(run.trajectory.stamps)}" + ("" if run.tracked is None else f" ({100 * run.tracked:.0f} %)")


def _length_m(run: MappedRun) -> float:
    positions = np.zeros((0, 3)) if run.trajectory is None else run.trajectory.world_from_camera[:, :3, 3]
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
