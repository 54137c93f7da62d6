"""A small room as a saved map, for tests of pages."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from tests.support.scenes import axis_box
from tests.support.voxel_surfaces import voxel_surface

SIZE_M = 0.1
COLORS = {1: (120, 90, 60), 2: (30, 60, 200), 3: (200, 40, 40), 4: (90, 160, 90)}
NAMES = {1: "floor", 2: "table", 3: "chair", 4: "cup"}
POSES = """\
0.0 2.0 1.0 1.6 0.9238795 0 0 -0.3826834
0.5 2.2 1.0 1.6 0.9238795 0 0 -0.3826834
1.0 2.4 1.2 1.6 0.9238795 0 0 -0.3826834
"""


def room_mesh() -> LabelledMesh:
    """A floor of 4 m x 4 m with a table, a chair, and a cup on the table; ids as in NAMES."""
    solids = np.zeros((44, 44, 20), np.int32)
    solids[2:42, 2:42, 2] = 1
    solids[8:20, 10:18, 3:10] = 2
    solids[28:32, 26:30, 3:8] = 3
    solids[12:14, 13:15, 10:12] = 4
    return voxel_surface(solids, COLORS, SIZE_M)


def room_map() -> PanopticMap:
    """The room with its instances; the chair was called a stool by one side."""
    mesh = room_mesh()
    objects = tuple(_object(mesh, number, name) for number, name in NAMES.items())
    return PanopticMap(objects, mesh, up=np.array([0.0, 0.0, 1.0]), stamps={})


def save_room(folder: Path) -> Path:
    """The room as the folder of a run."""
    room_map().save(folder)
    (folder / "trajectory.txt").write_text(POSES)
    (folder / "config.toml").write_text("")
    return folder


def _object(mesh: LabelledMesh, number: int, name: str) -> MapObject:
    points = mesh.vertices[mesh.instances == number]
    low, high = points.min(axis=0), points.max(axis=0)
    box: OrientedBox = axis_box((low + high) / 2, high - low)
    votes = (ClassVote(name, 0, 5, 4.0, 0.9), *((ClassVote("stool", 1, 2, 1.0, 0.6),) if name == "chair" else ()))
    vector = np.eye(4, dtype=np.float32)[number - 1 : number]
    return MapObject(
        number, name, 0.5 + number / 10, box, len(points), len(points), 9, 0, 2, vector, np.ones(1), (),
        name == "floor", votes,
    )  # fmt: skip
