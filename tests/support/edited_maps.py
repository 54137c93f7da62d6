"""A small map made by hand, to be edited: a table with two chairs, a lamp that touches nothing, on a floor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.detection.best_views import BestView, Region
from razer.edits.edit import edit_of
from razer.edits.session import EditSession
from razer.map_object import MapObject
from razer.models import make_embedder
from razer.panoptic_map import PanopticMap
from razer.query.text_queries import TextQueryEncoder
from tests.support.voxel_surfaces import voxel_surface

TABLE, CHAIR, OTHER_CHAIR, LAMP, FLOOR, WALL = 1, 2, 3, 4, 5, 6
NAMES = {TABLE: "table", CHAIR: "chair", OTHER_CHAIR: "chair", LAMP: "lamp", FLOOR: "floor", WALL: "wall"}
SIZE_M = 0.05
NOW = "2025-01-01T12:00:00Z"


def solids() -> np.ndarray:
    grid = np.zeros((44, 24, 24), int)
    grid[1:43, 1:23, 1] = FLOOR
    grid[1:43, 22, 2:22] = WALL
    grid[4:16, 8:16, 2:10] = TABLE
    grid[16:20, 8:12, 2:8] = CHAIR
    grid[24:28, 8:12, 2:8] = OTHER_CHAIR
    grid[36:40, 8:12, 12:16] = LAMP
    return grid


def hand_made() -> PanopticMap:
    """The map, in memory; each instance's embedding is its name's vector, and it was called so from three sides."""
    embedder = make_embedder("oracle", {})
    mesh = voxel_surface(solids(), {}, SIZE_M)
    objects = tuple(_object(i, name, mesh, embedder) for i, name in NAMES.items())
    return PanopticMap(objects, mesh, TextQueryEncoder(embedder), up=np.array([0.0, 0.0, 1.0]))


def _object(number, name, mesh, embedder):
    points = mesh.vertices[mesh.instances == number].astype(float)
    return MapObject(
        id=number,
        class_name=name,
        score=0.5 + 0.05 * number,
        box=OrientedBox.of_surface(points),
        n_voxels=2 * len(points),
        n_vertices=len(points),
        observations=10 * number,
        first_frame=10 - number,
        last_frame=50 + number,
        embeddings=embedder.embed_texts([name]),
        weights=np.ones(1),
        views=(BestView(20 * number, Region((0, 0, 10, 10), 1000 * number, True)),),
        is_stuff=name in ("floor", "wall"),
        class_votes=tuple(ClassVote(name, sector, 3, 1.5, 0.8) for sector in range(3)),
    )


def saved(folder: Path) -> Path:
    """A folder that the map is saved in."""
    hand_made().save(folder)
    return folder


def session_of(folder: Path) -> EditSession:
    """A session on the hand-made map whose log lies in a folder."""
    return EditSession(folder, hand_made())


def do(session: EditSession, kind: str, epoch: int | None = None, **fields):
    """Apply an edit given by its fields; `source` and `target` stand for from and to."""
    fields = {{"source": "from", "target": "to", "class_name": "class"}.get(k, k): v for k, v in fields.items()}
    return session.apply(edit_of({"kind": kind, **fields}), time=NOW, author="ann", epoch=epoch)


def plane(x: float, y: float, z: float, offset_m: float) -> dict[str, object]:
    return {"plane": {"normal": [x, y, z], "offset_m": offset_m}}


def vertices_of(panoptic: PanopticMap, number: int) -> set[int]:
    return set(np.flatnonzero(panoptic.mesh.instances == number).tolist())


def by_id(panoptic: PanopticMap) -> dict[int, MapObject]:
    return {item.id: item for item in panoptic.objects}


def same_map(one: PanopticMap, other: PanopticMap) -> bool:
    """Whether two maps hold the same, to the byte."""
    arrays = all(
        getattr(one.mesh, name).tobytes() == getattr(other.mesh, name).tobytes()
        for name in ("vertices", "colors", "instances", "triangles")
    )
    return arrays and len(one.objects) == len(other.objects) and all(map(same_object, one.objects, other.objects))


def same_object(one: MapObject, other: MapObject) -> bool:
    def arrays(item: MapObject) -> list[bytes]:
        box = item.box
        parts = (item.embeddings, item.weights, box.center, box.rotation, box.extent)
        return [part.tobytes() for part in parts]

    plain = [repr(replace(item, embeddings=np.zeros(0), weights=np.zeros(0), box=UNIT)) for item in (one, other)]
    return plain[0] == plain[1] and arrays(one) == arrays(other)


UNIT = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
