"""What speaks for the poses of one run or another over the same frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from app.run_folder.mapped_run import MappedRun
from app.timeline.depth_agreement import MAX_IMAGES, pair_offsets_m
from app.timeline.recording.saved_recording import DepthImages
from razer.arrays import Float64Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.trajectory_errors import match_timestamps
from razer.metrics.umeyama import align_views

SAME_TIME_S = 0.01
CLEARLY = 0.1  # less of an offset, in MOST of the pairs of images, makes poses better
MOST = 0.75
ADVICE = (
    "Depth images are looked at from where others were taken, and the distance between what both show is the "
    "*offset*: noise of the sensor, and errors of the poses. *Overview* shows what these do: walls and edges twice. "
    "`razer compare` measures more."
)


def world_from_other(first: MappedRun, other: MappedRun) -> Float64Array:
    """The motion (4, 4) into the world of the first run, by the frames that both have a pose of; without any none."""
    ours, theirs, _ = _common(first, other)
    return align_views(theirs, ours) if len(ours) else np.eye(4)


def pose_figures(runs: Mapping[str, MappedRun], depth: DepthImages | None) -> str:
    """Markdown: which of two runs, by name, has the better poses, a table of them, and how far apart their paths are.

    Args:
        runs: two runs of the same recording.
        depth: images of it, if there are any.
    """
    offsets_m = _offsets_m(list(runs.values()), depth) if depth is not None else np.zeros((2, 0))
    rows = {
        "frames with a pose": [_tracked(run) for run in runs.values()],
        "offset": [f"{100 * offset:.1f} cm" for offset in offsets_m.mean(axis=1)] if offsets_m.size else [],
        "walked": [f"{_length_m(run):.1f} m" for run in runs.values()],
        "objects": [f"{sum(not item.is_stuff for item in run.panoptic.objects)}" for run in runs.values()],
        "surface": [f"{surface_area_m2(run.panoptic.mesh):.1f} m²" for run in runs.values()],
    }
    table = ["| | " + " | ".join(runs) + " |", "|---|" + "--:|" * len(runs)]
    table += [f"| {name} | " + " | ".join(values) + " |" for name, values in rows.items() if values]
    first, second = list(runs.values())[:2]
    return "\n".join([better(list(runs), offsets_m), "", *table, "", _apart(first, second), "", ADVICE])


def better(names: Sequence[str], offsets_m: Float64Array) -> str:
    """In one line which of two runs has the better poses, by offsets (2, P) of the same pairs of images."""
    if not offsets_m.size:
        return "**No two depth images show the same place**, so these figures do not tell which poses are better."
    means_cm = 100 * offsets_m.mean(axis=1)
    best = int(means_cm.argmin())
    share = float((offsets_m[best] < offsets_m[1 - best]).mean())
    said = f"{names[best]} {means_cm[best]:.1f} cm, {names[1 - best]} {means_cm[1 - best]:.1f} cm"
    if means_cm[best] > (1 - CLEARLY) * means_cm[1 - best] or share < MOST:
        return f"**No clear difference**: depth images agree about as well under both ({said})."
    return f"**{names[best]} has the better poses**: its depth images agree better ({said})."


def _offsets_m(runs: Sequence[MappedRun], depth: DepthImages) -> Float64Array:
    """Offsets (2, P) of pairs of images that both runs have poses of."""
    if any(run.trajectory is None for run in runs):
        return np.zeros((2, 0))
    poses, seen = [], set(range(len(depth.stamps)))
    for run in runs:
        assert run.trajectory is not None
        ours, theirs = match_timestamps(depth.stamps, run.trajectory.stamps, SAME_TIME_S)
        found = dict(zip(ours.tolist(), run.trajectory.world_from_camera[theirs].astype(np.float64), strict=True))
        poses.append(found)
        seen &= found.keys()
    rows = sorted(seen)
    rows = rows[:: len(rows) // MAX_IMAGES + 1]
    if len(rows) < 2:
        return np.zeros((2, 0))
    images = [depth.images_m[row] for row in rows]
    offsets_m = np.stack(
        [pair_offsets_m(images, depth.camera, np.array([found[row] for row in rows])) for found in poses]
    )
    return offsets_m[:, np.isfinite(offsets_m).all(axis=0)]


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
