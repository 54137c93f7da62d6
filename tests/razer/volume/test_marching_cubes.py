"""Marching cubes part by part against Open3D's on one grid of all blocks."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import open3d.core as o3c
import pytest
import torch

import razer.volume.blocks.block_pages
import razer.volume.marching_cubes
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, box_depth, frame_of, plane_depth, pose

Triangle = tuple[tuple[float, ...], ...]


@pytest.fixture(scope="module")
def mapped() -> VoxelMap:
    """A slanted wall and a box from several sides, and a wall that lies on the lattice exactly."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 16)
        voxels = VoxelMap(COARSE)
        box = axis_box((0.1, 0.0, 1.3), (0.4, 0.4, 0.3))
        for x, turn in ((0.0, 0.0), (0.2, -8.0), (-0.3, 10.0)):
            at = pose((x, 0, 0), (0, turn, 0))
            seen = np.minimum(plane_depth(at, (0.1, -0.05, 1), 2.1), box_depth(at, box))
            for _ in range(3):
                voxels.integrate(frame_of(seen, at, rgb=(int(100 + 300 * (x + 0.3)), 90, 40)))
        for _ in range(3):
            voxels.integrate(frame_of(np.full((120, 160), 1.0), pose((6, 0, 0))))
        return voxels


def of_one_grid(voxels: VoxelMap) -> tuple[set[tuple[float, ...]], list[Triangle]]:
    """Positions of vertices, and triangles by the positions of their corners, those without area left out."""
    keys, rows = voxels.pages.all()
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight", "color"),
        (o3c.float32,) * 3,
        tuple(o3c.SizeVector([n]) for n in (1, 1, 3)),
        COARSE.voxel_size_m,
        16,
        len(keys),
    )
    grid.hashmap().activate(o3c.Tensor(keys))
    places = grid.hashmap().find(o3c.Tensor(keys))[0].to(o3c.int64).numpy()
    for name in ("tsdf", "weight", "color"):
        view = torch.utils.dlpack.from_dlpack(grid.attribute(name).to_dlpack())
        view.flatten(1, 3)[places] = voxels.pages.blocks(rows, name).cpu()
    mesh = grid.extract_triangle_mesh(float(np.nextafter(np.float32(COARSE.surface_weight), np.float32(-1))))
    vertices = [tuple(v) for v in mesh.vertex.positions.numpy().tolist()]
    corners = [[vertices[i] for i in triangle] for triangle in mesh.triangle.indices.numpy().tolist()]
    return {*vertices}, sorted(from_lowest(t) for t in corners if len({*t}) == 3)


def from_lowest(corners: list[tuple[float, ...]]) -> Triangle:
    first = corners.index(min(corners))
    return (*corners[first:], *corners[:first])


@pytest.mark.parametrize("part_blocks", [1, 5, 10_000])
def test_the_mesh_is_that_of_one_grid(mapped: VoxelMap, part_blocks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.marching_cubes, "PART_BLOCKS", part_blocks)
    vertices, triangles = of_one_grid(mapped)
    assert mapped.n_blocks > 40
    assert len(triangles) > 2000
    mesh = extract_mesh(mapped)
    positions = [tuple(v) for v in mesh.vertices.tolist()]
    assert positions == sorted(vertices)
    assert sorted(from_lowest([positions[i] for i in t]) for t in mesh.triangles.tolist()) == triangles


def test_colours_do_not_depend_on_the_parts(mapped: VoxelMap, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = extract_mesh(mapped)
    monkeypatch.setattr(razer.volume.marching_cubes, "PART_BLOCKS", 3)
    in_parts = extract_mesh(mapped)
    for name, array in vars(whole).items():
        assert array.tobytes() == vars(in_parts)[name].tobytes(), name
    assert len(np.unique(whole.colors, axis=0)) >= 3
