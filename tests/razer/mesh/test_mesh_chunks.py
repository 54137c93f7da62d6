"""Chunks of a mesh: together they are all of it, and each holds what lies in it."""

from __future__ import annotations

import numpy as np
import pytest

from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk, blocks_of, by_chunk

EDGE_M = 1.28


def grid_mesh(n: int, step_m: float) -> LabelledMesh:
    """A level square of n x n vertices around the origin, each with an id of its own."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    vertices = np.stack([x * step_m, y * step_m, 0 * x], axis=-1).reshape(-1, 3).astype(np.float32) - n * step_m / 2
    corner = (x * n + y)[:-1, :-1].ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + n, corner + 1], 1), np.stack([corner + 1, corner + n, corner + n + 1], 1)]
    )
    ids = np.arange(n * n, dtype=np.int32)
    return LabelledMesh(vertices, np.zeros((n * n, 3), np.uint8), ids, triangles.astype(np.int32))


@pytest.mark.parametrize("per_edge", [1, 2, 4])
def test_a_chunk_knows_its_blocks(per_edge: int) -> None:
    keys = blocks_of([Chunk(-1, 0, 2)], per_edge)
    assert len(np.unique(keys, axis=0)) == per_edge**3
    assert (keys // per_edge == (-1, 0, 2)).all()
    assert len(blocks_of([Chunk(0, 0, 0), Chunk(5, 5, 5)], per_edge)) == 2 * per_edge**3
    assert blocks_of([], per_edge).shape == (0, 3)


def test_a_mesh_is_parted_into_chunks_that_hold_all_of_it() -> None:
    mesh = grid_mesh(100, 0.05)
    parts = by_chunk(mesh, EDGE_M)
    assert sum(len(part.triangles) for part in parts.values()) == len(mesh.triangles)
    together = np.concatenate([part.vertices[part.triangles] for part in parts.values()])
    assert {t.tobytes() for t in together} == {t.tobytes() for t in mesh.vertices[mesh.triangles]}
    for chunk, part in parts.items():
        middles = part.vertices[part.triangles].mean(axis=1)
        assert (np.floor(middles / EDGE_M) == np.array(chunk)).all()
        assert set(part.triangles.ravel().tolist()) == set(range(len(part.vertices)))
        np.testing.assert_array_equal(part.vertices, mesh.vertices[part.instances])  # labels go with their vertices


def test_no_surface_is_in_no_chunk() -> None:
    assert by_chunk(LabelledMesh.empty(), EDGE_M) == {}
