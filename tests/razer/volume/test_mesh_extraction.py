"""Taking the surface out: its order, its labels by hand, and parts of it."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import razer.volume.blocks.block_pages
from razer.volume.mesh_extraction import extract_mesh, extract_points, fill_seams, vertex_labels
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, box_depth, cells_at, frame_of, look, plane_depth, pose

SIZE_M = COARSE.voxel_size_m
BOX = axis_box((0.1, 0.0, 1.3), (0.4, 0.4, 0.3))


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


def furnished() -> VoxelMap:
    """A wall, 1, and a box, 2."""
    voxels = VoxelMap(COARSE)
    voxels.admit(2)
    for at in [pose(), pose((0.2, 0, 0), (0, -8, 0))] * 2:
        frame = frame_of(np.minimum(plane_depth(at, (0, 0, 1), 2.0), box_depth(at, BOX)), at)
        voxels.integrate(frame)
        voxels.vote(look(frame).cells, np.where(look(frame).cells.points[:, 2] > 1.8, 1, 2).astype(np.int32))
    return voxels


@pytest.fixture(scope="module")
def mapped() -> VoxelMap:
    """`furnished`, for tests that only look."""
    return furnished()


def sorted_rows(table: np.ndarray) -> np.ndarray:
    return table[np.lexsort(table.T[::-1])]


def test_vertices_and_triangles_are_in_canonical_order(mapped: VoxelMap) -> None:
    mesh = extract_mesh(mapped)
    assert len(mesh.triangles) > 500
    assert np.array_equal(mesh.vertices, sorted_rows(mesh.vertices))
    assert np.array_equal(mesh.triangles, sorted_rows(mesh.triangles))
    assert (mesh.triangles[:, 0] < mesh.triangles[:, 1:].min(axis=1)).all()
    assert len(mesh.vertices) == len(mesh.colors) == len(mesh.instances)
    assert mesh.triangles.max() < len(mesh.vertices)


def test_triangles_face_the_camera(mapped: VoxelMap) -> None:
    """Sorting must keep the winding: what lies across the view points back to where it was seen from."""
    mesh = extract_mesh(mapped)
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across = np.abs(normals[:, 2]) > 0.7 * np.linalg.norm(normals, axis=1)
    assert np.count_nonzero(across) > 1000
    assert (normals[across, 2] < 0).all()


def test_the_same_frames_give_the_same_mesh_bit_for_bit(mapped: VoxelMap) -> None:
    one, other = extract_mesh(mapped), extract_mesh(furnished())
    for name, array in vars(one).items():
        assert array.tobytes() == vars(other)[name].tobytes(), name


def test_labels_of_vertices_and_points_are_right_on_either_side(mapped: VoxelMap) -> None:
    mesh, points = extract_mesh(mapped), extract_points(mapped)
    for positions, instances in ((mesh.vertices, mesh.instances), (points.positions, points.instances)):
        wall, front = positions[:, 2] > 1.9, np.abs(positions[:, 2] - 1.15) < 0.03
        # Band and silhouette voxels that no depth pixel reached have nobody's label.
        assert set(instances[wall]) <= {0, 1}
        assert set(instances[front]) <= {0, 2}
        assert (instances[wall] == 1).mean() > 0.5
        assert (instances[front] == 2).mean() > 0.5


def test_colours_are_those_of_the_image(mapped: VoxelMap) -> None:
    for found in (extract_mesh(mapped), extract_points(mapped)):
        assert found.colors.dtype == np.uint8
        assert np.abs(found.colors.astype(int) - (200, 100, 50)).max() <= 1, type(found)


def test_points_are_voxels_near_the_zero_crossing(mapped: VoxelMap) -> None:
    points = extract_points(mapped)
    lattice = points.positions / SIZE_M
    assert_allclose(lattice, np.rint(lattice), atol=1e-3)
    wall = points.positions[:, 2] > 1.8
    assert_allclose(points.positions[wall, 2], 2.0, atol=0.75 * SIZE_M + 1e-6)
    assert len(np.unique(np.rint(lattice), axis=0)) == len(lattice)


def test_points_of_some_blocks_are_those_of_all_that_lie_in_them(mapped: VoxelMap) -> None:
    whole = extract_points(mapped)
    chosen = mapped.pages.all()[0][::3]
    block = np.floor(np.rint(whole.positions / SIZE_M) / 16).astype(int)
    inside = (block[:, None] == chosen[None]).all(axis=2).any(axis=1)
    part = extract_points(mapped, np.concatenate([chosen, [[900, 900, 900]]]).astype(np.int32))
    assert 0 < len(part.positions) < len(whole.positions)
    for name, array in vars(part).items():
        assert np.array_equal(array, vars(whole)[name][inside]), name


def test_points_of_no_blocks_are_none(mapped: VoxelMap) -> None:
    assert len(extract_points(mapped, np.zeros((0, 3), np.int32)).positions) == 0


def test_points_read_labels_through_fusions() -> None:
    voxels = furnished()
    before = extract_points(voxels).instances
    voxels.replace(2, 1)
    assert np.array_equal(extract_points(voxels).instances, np.minimum(before, 1))
    voxels.replace(1, 0)
    assert not extract_points(voxels).instances.any()


@pytest.mark.parametrize(
    ("left", "right", "is_surface"), [(0, 1, True), (20, 1, True), (21, 1, False), (50, 2, False), (50, 3, True)]
)
def test_points_and_mesh_need_a_twentieth_of_what_their_block_has_and_three_at_most(
    left: int, right: int, is_surface: bool
) -> None:
    """The left half of a wall is seen so many times, the right half fewer times, both halves of one block's rows."""
    voxels, depth = VoxelMap(COARSE), np.full((120, 160), 1.5)
    for n, columns in ((left, slice(0, 80)), (right, slice(80, 160))):
        half = np.zeros_like(depth)
        half[:, columns] = depth[:, columns]
        for _ in range(n):
            voxels.integrate(frame_of(half))
    # Blocks are 64 cm wide here, and that in the middle holds both halves: its right-hand surface is looked at.
    for positions in (extract_points(voxels).positions, extract_mesh(voxels).vertices):
        in_block = (positions[:, 0] > 0.1) & (positions[:, 0] < 0.5) & (np.abs(positions[:, 1] - 0.3) < 0.2)
        assert in_block.any() == is_surface


def voted(table: Mapping[Any, dict[int, int]]) -> VoxelMap:
    """A map in which each cell has the given number of votes for each id."""
    voxels = VoxelMap(COARSE)
    voxels.admit(9)
    voxels.allocate(np.unique(np.floor_divide(list(table), 16), axis=0).astype(np.int32))
    for cell, tally in table.items():
        for label, count in tally.items():
            for _ in range(count):
                voxels.vote(cells_at([cell]), np.array([label], np.int32))
    return voxels


def label_at(voxels: VoxelMap, *point: float) -> int:
    """The label of the vertex at a point in lattice units."""
    return int(vertex_labels(voxels, np.array([point], np.float32) * np.float32(SIZE_M))[0])


def test_a_vertex_takes_the_label_of_most_votes_around() -> None:
    voxels = voted({(0, 0, 0): {1: 2}, (1, 0, 0): {2: 3}, (0, 1, 1): {1: 2}, (4, 0, 0): {3: 9}})
    assert label_at(voxels, 0.5, 0.5, 0.5) == 1  # 4 votes against 3
    assert label_at(voxels, 0.9, 0.1, 0.1) == 2  # the nearer neighbour weighs more
    assert label_at(voxels, 2.5, 0.5, 0.5) == 0  # nobody voted
    assert label_at(voxels, 3.5, 0.2, 0.2) == 3


def test_one_ids_votes_add_up_over_cells_and_equal_sums_go_to_the_lowest_id() -> None:
    spread = {(0, 0, 0): {5: 2, 1: 1}, (1, 1, 1): {5: 2, 1: 1}, (0, 1, 0): {1: 1}, (1, 0, 0): {1: 1}}
    assert label_at(voted(spread), 0.5, 0.5, 0.5) == 1  # 4 against 4


def test_vertices_across_block_borders_and_below_zero() -> None:
    voxels = voted({(15, 0, 0): {1: 1}, (16, 0, 0): {2: 3}, (-1, -1, -1): {4: 1}})
    assert label_at(voxels, 15.4, 0.0, 0.0) == 2
    assert label_at(voxels, 15.1, 0.0, 0.0) == 1
    assert label_at(voxels, -0.5, -0.5, -0.5) == 4


def test_vertex_labels_by_a_slow_vote() -> None:
    rng = np.random.default_rng(0)
    cells = rng.integers(-3, 3, (60, 3))
    table = {tuple(map(int, c)): {int(rng.integers(1, 5)): int(rng.integers(1, 4))} for c in cells}
    voxels = voted(table)
    points = rng.uniform(-3, 3, (80, 3))
    for point, label in zip(points, vertex_labels(voxels, (points * SIZE_M).astype(np.float32)), strict=True):
        tally: dict[int, float] = defaultdict(float)
        low = np.floor(point).astype(int)
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, point - low, 1 - (point - low)))
            for who, count in table.get(tuple(low + corner), {}).items():
                tally[who] += count * max(float(weight), 0.02)
        best = max(tally.values(), default=0.0)
        # Weights are rounded: nearly equal sums may go either way.
        assert label in {who for who, votes in tally.items() if votes > best - 0.02} or (label == 0 and not tally)


def slow_fill(labels: list[int], triangles: list[list[int]], rings: int) -> list[int]:
    beside: list[set[int]] = [set() for _ in labels]
    for triangle in triangles:
        for a, b in permutations(triangle, 2):
            beside[a] |= {b} - {a}
    for _ in range(rings):
        near = [Counter(labels[b] for b in others if labels[b]) for others in beside]
        most = [min((-n, i) for i, n in tally.items())[1] if tally else 0 for tally in near]
        labels = [own or new for own, new in zip(labels, most, strict=True)]
    return labels


@pytest.mark.parametrize("rings", [0, 1, 3])
def test_seams_are_filled_as_by_a_literal_loop(rings: int) -> None:
    rng = np.random.default_rng(rings)
    for _ in range(20):
        triangles = rng.integers(0, 40, (30, 3)).astype(np.int32)
        labels = (rng.integers(1, 4, 40) * (rng.random(40) < 0.3)).astype(np.int32)
        filled = fill_seams(labels, triangles, rings)
        assert filled.tolist() == slow_fill(labels.tolist(), triangles.tolist(), rings)
        assert filled.dtype == np.int32


def test_seams_of_a_mesh_without_triangles_or_without_labels_stay() -> None:
    labels = np.array([0, 3, 0], np.int32)
    assert fill_seams(labels, np.zeros((0, 3), np.int32), 3).tolist() == [0, 3, 0]
    triangle = np.array([[0, 1, 2]], np.int32)
    assert fill_seams(np.zeros(3, np.int32), triangle, 3).tolist() == [0, 0, 0]
    assert fill_seams(np.array([1, 3, 2], np.int32), triangle, 3).tolist() == [1, 3, 2]


def test_an_empty_map_has_no_points() -> None:
    assert extract_points(VoxelMap(COARSE)).positions.shape == (0, 3)


def test_a_map_without_surface_has_an_empty_mesh() -> None:
    unseen = VoxelMap(COARSE)
    unseen.allocate(np.zeros((1, 3), np.int32))
    for voxels in (unseen, VoxelMap(COARSE)):
        mesh = extract_mesh(voxels)
        assert mesh.vertices.shape == mesh.colors.shape == mesh.triangles.shape == (0, 3)
        assert mesh.instances.shape == (0,)
