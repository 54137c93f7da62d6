"""A finished run, read back: its map and its trajectory."""

from __future__ import annotations

import json
import zipfile
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.evaluation.prediction import is_run, timed_poses
from app.run_folder import run_folder as names
from razer.arrays import Float32Array, Float64Array, Int32Array
from razer.boxes.oriented_box import OrientedBox
from razer.detection.best_views import BestView, Region
from razer.errors import BadInput
from razer.geometry import transform_points
from razer.metrics.scene_pair import TimedPoses
from razer.panoptic_map import MapObject, PanopticMap
from razer.storage import read_mesh_ply


@dataclass(frozen=True)
class MappedRun:
    """The map of a run and its trajectory, both in the same frame; name, that of its folder."""

    name: str
    panoptic: PanopticMap
    trajectory: TimedPoses

    @property
    def tracked(self) -> float | None:
        """The share of the frames the run looked at that have a pose; None where it did not count them."""
        n_frames = self.trajectory.n_frames
        return len(self.trajectory.stamps) / n_frames if n_frames else None

    def moved(self, target_from_own: Float64Array) -> MappedRun:
        """The same run in another frame."""
        mesh = self.panoptic.mesh
        vertices = transform_points(target_from_own, mesh.vertices.astype(np.float64)).astype(np.float32)
        objects = tuple(replace(o, box=_moved_box(target_from_own, o.box)) for o in self.panoptic.objects)
        return MappedRun(
            self.name,
            PanopticMap(objects, replace(mesh, vertices=vertices)),
            moved_poses(target_from_own, self.trajectory),
        )


def moved_poses(target_from_own: Float64Array, trajectory: TimedPoses) -> TimedPoses:
    """A trajectory in another frame."""
    return replace(trajectory, world_from_camera=target_from_own @ trajectory.world_from_camera)


def _moved_box(target_from_own: Float64Array, box: OrientedBox) -> OrientedBox:
    rotation = target_from_own[:3, :3] @ box.rotation
    return OrientedBox(transform_points(target_from_own, box.center), rotation, box.extent)


def read_run(folder: Path) -> MappedRun:
    """What a run left; raises BadInput naming what is missing or broken."""
    if not is_run(folder):
        raise BadInput(f"{folder} is no run folder (no {names.INSTANCES} or no {names.MESH_PLY})")
    mesh = read_mesh_ply(folder / names.MESH_PLY)
    try:
        listed = json.loads((folder / names.INSTANCES).read_text())["instances"]
        with np.load(folder / names.EMBEDDINGS) as bank:
            ids, embeddings, weights = bank["ids"], bank["embeddings"], bank["weights"]
        n_vertices = Counter(mesh.instances.tolist())
        banks = _banks(ids, embeddings, weights)
        objects = tuple(_object(entry, banks, n_vertices[int(entry["id"])]) for entry in listed)
    except (OSError, EOFError, KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
        raise BadInput(
            f"{folder}: {names.INSTANCES} or {names.EMBEDDINGS} is missing or damaged ({error}); run again"
        ) from error
    known = np.isin(mesh.instances, [o.id for o in objects])
    mesh = replace(mesh, instances=np.where(known, mesh.instances, 0).astype(np.int32))
    return MappedRun(folder.absolute().name, PanopticMap(objects, mesh), _trajectory(folder))


def _banks(
    ids: Int32Array, embeddings: Float32Array, weights: Float64Array
) -> dict[int, tuple[Float32Array, Float64Array]]:
    """The rows of each id, which lie together."""
    known, first = np.unique(ids, return_index=True)
    order = np.argsort(first)
    parts = [np.split(rows, np.sort(first)[1:]) for rows in (embeddings, weights)]
    return {int(i): (e, w) for i, e, w in zip(known[order], *parts, strict=True)} if len(known) else {}


def _object(entry: dict[str, Any], banks: dict[int, tuple[Float32Array, Float64Array]], n_vertices: int) -> MapObject:
    embeddings, weights = banks.get(int(entry["id"]), (np.zeros((0, 0), np.float32), np.zeros(0)))
    box = OrientedBox(*(np.array(entry[part], np.float64) for part in ("center", "rotation", "extent")))
    counts: dict[str, Any] = {key: int(entry[key]) for key in ("n_voxels", "observations", "first_frame", "last_frame")}
    return MapObject(
        id=int(entry["id"]),
        class_name=entry["class"],
        score=float(entry["score"]),
        box=box,
        n_vertices=n_vertices,
        embeddings=embeddings,
        weights=weights,
        views=tuple(_view(view) for view in entry.get("best_views", ())),
        **counts,
    )


def _view(entry: dict[str, Any]) -> BestView:
    x, y, width, height = (int(number) for number in entry["box"])
    region = Region((x, y, width, height), int(entry["pixels"]), bool(entry["whole"]))
    return BestView(int(entry["frame"]), region, entry["stamp"])


def _trajectory(folder: Path) -> TimedPoses:
    path = folder / names.TRAJECTORY
    if not path.is_file():
        raise BadInput(f"{folder} has no {names.TRAJECTORY}: run again to write it")
    poses = timed_poses(path)
    return replace(poses, n_frames=_frames_looked_at(folder, len(poses.stamps)))


def _frames_looked_at(folder: Path, n_poses: int) -> int | None:
    """How many frames a run looked at, with those it could not locate, as its timings say."""
    try:
        frames = int(json.loads((folder / names.TIMINGS).read_text())["frames"])
    except (OSError, KeyError, ValueError, TypeError):
        return None
    return frames if frames >= n_poses else None
