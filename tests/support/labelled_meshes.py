"""A small furnished room as a labelled mesh, as scans are: coloured vertices, holes, any axis up."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.synthetic.layout.building import flat
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.truth.tessellation import tessellate
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_truth

GREY = tinted("smooth", (200.0, 200.0, 200.0))
LENGTH_M, WIDTH_M, HEIGHT_M = 4.2, 3.4, 2.5
TABLE = ((-0.6, -0.4), (0.6, 0.4))  # corners (x, y) of what stands in the middle
HOLE = (0.0, WIDTH_M / 2, 1.4)  # middle of a hole in the wall "north", radius 0.4 m
HOLE_M = 0.4
Z_TO_Y = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def furnished_room(spacing_m: float = 0.08, noise_m: float = 0.0) -> GroundTruth:
    """Floor, four walls that face inwards, a table in the middle, a cabinet and a lamp; z up, floor at 0, a hole in one
    wall and no ceiling; every vertex has a colour of its place."""
    x, y, z = LENGTH_M / 2, WIDTH_M / 2, HEIGHT_M
    things = {
        1: Thing("floor", (flat((-x, -y, 0), (2 * x, 0, 0), (0, 2 * y, 0), GREY),)),
        2: Thing("wall", (flat((x, -y, 0), (-2 * x, 0, 0), (0, 0, z), GREY),)),
        3: Thing("wall", (flat((x, y, 0), (0, -2 * y, 0), (0, 0, z), GREY),)),
        4: Thing("wall", (flat((-x, y, 0), (2 * x, 0, 0), (0, 0, z), GREY),)),
        5: Thing("wall", (flat((-x, -y, 0), (0, 2 * y, 0), (0, 0, z), GREY),)),
        6: Thing("table", (block(0, 0, 0, (1.2, 0.8, 0.75), GREY),)),
        7: Thing("cabinet", (block(-x + 0.25, -y + 0.5, 0, (0.46, 0.9, 1.3), GREY),)),
        8: Thing("lamp", (block(x - 0.3, y - 0.3, 0, (0.3, 0.3, 1.6), GREY),)),
    }
    surface = tessellate(things, spacing_m)
    wander = np.random.default_rng(1).normal(0, noise_m, (len(surface.vertices), 1)) if noise_m else 0.0
    vertices = (surface.vertices + wander * surface.normals).astype(np.float32)
    middles = vertices[surface.triangles].mean(axis=1)
    names = sorted({thing.class_name for thing in things.values()})
    class_of = np.array([0, *(names.index(thing.class_name) + 1 for thing in things.values())], np.int32)
    colors = (120 + 50 * np.sin(1.3 * vertices + np.outer(surface.instances, (1, 2, 3)))).astype(np.uint8)
    return GroundTruth(
        vertices,
        surface.triangles[np.linalg.norm(middles - HOLE, axis=1) > HOLE_M],
        surface.instances,
        class_of[surface.instances],
        dict(enumerate(names, start=1)),
        np.ones(len(vertices), np.bool_),
        colors=colors,
    )


def write_room(folder: Path, spacing_m: float = 0.08, noise_m: float = 0.0) -> Path:
    """The room as a truth of our own; returns its mesh."""
    folder.mkdir(parents=True)
    write_truth(furnished_room(spacing_m, noise_m), folder)
    return folder / "mesh.ply"
