"""The volume: a fused plane, votes against slow counts, fusions, and growth while it is in use."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from numpy.testing import assert_allclose

import razer.volume.blocks.block_pages
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK_VOXELS, Cells
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.volume.mesh_extraction import extract_mesh, extract_points
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import (
    ATTRIBUTES,
    COARSE,
    cells_at,
    contents,
    frame_of,
    look,
    plane_depth,
    pose,
    same_contents,
)

NORMAL = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
DISTANCE_M = 1.5
POSES = [pose(), pose((0.4, 0.1, -0.2), (4, -12, 2)), pose((-0.3, -0.2, 0.1), (-6, 9, 30))]
DEVICES = ["CPU:0", pytest.param("CUDA:0", marks=pytest.mark.gpu)]


@pytest.fixture(params=DEVICES)
def device(request: pytest.FixtureRequest) -> str:
    """Each device in turn; CUDA:0 only where there is one."""
    return str(request.getfixturevalue("cuda")) if request.param == "CUDA:0" else str(request.param)


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for what these maps need: whole attributes are quicker to compare."""
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


def plane_frames() -> list[Frame]:
    return [frame_of(plane_depth(at, NORMAL, DISTANCE_M), at, index=i) for i, at in enumerate(POSES)]


def fused_plane(device: str = "CPU:0", settings: VoxelSettings = COARSE) -> VoxelMap:
    voxels = VoxelMap(settings, device)
    for frame in plane_frames():
        voxels.integrate(frame)
    return voxels


def histograms(voxels: VoxelMap, cells: Cells) -> list[dict[int, int]]:
    ids, counts = (t.tolist() for t in voxels.histograms_at(cells))
    return [{i: n for i, n in zip(*row, strict=True) if n} for row in zip(ids, counts, strict=True)]


def test_mesh_of_a_plane_lies_on_the_plane(device: str) -> None:
    voxels = fused_plane(device)
    voxels.integrate(plane_frames()[0])  # a fourth time: the mesh needs more than `surface_weight`
    mesh = extract_mesh(voxels)
    assert len(mesh.vertices) > 500
    assert np.abs(mesh.vertices @ NORMAL - DISTANCE_M).max() < COARSE.voxel_size_m / 2
    assert np.abs(mesh.colors.astype(int) - (200, 100, 50)).max() <= 1
    # The middle of the plane is covered: no holes in a grid of probes as wide as a voxel.
    x, y = np.meshgrid(np.arange(-0.3, 0.3, 0.04), np.arange(-0.3, 0.3, 0.04))
    probes = np.stack([x, y, (DISTANCE_M - NORMAL[0] * x - NORMAL[1] * y) / NORMAL[2]], axis=-1).reshape(-1, 3)
    gaps = np.linalg.norm(probes[:, None] - mesh.vertices[None], axis=2).min(axis=1)
    assert gaps.max() < COARSE.voxel_size_m


def test_integration_is_the_weighted_mean_of_projective_distances(device: str) -> None:
    voxels = VoxelMap(COARSE, device)
    walls_m = [1.50, 1.52, 1.56]
    for wall_m in walls_m:
        voxels.integrate(frame_of(np.full((120, 160), wall_m)))
    cells = cells_at([[0, 0, z] for z in range(36, 41)])
    addresses, known = voxels._addresses(cells)
    assert len(known) == 5
    tsdf, weight = (column[:, 0].cpu().numpy() for column in voxels.pages.read(addresses, "tsdf", "weight"))
    tsdf = tsdf * voxels.settings.truncation_m
    assert_allclose(tsdf, np.mean(walls_m) - cells.points[:, 2], atol=1e-4)
    assert_allclose(weight, 3.0)


def test_depth_out_of_range_is_not_fused() -> None:
    voxels = VoxelMap(COARSE)
    depth = np.full((120, 160), 6.0)
    depth[:, :50] = 0.05
    depth[:, 100:] = 2.0
    voxels.integrate(frame_of(depth))
    points = extract_points(voxels, voxels.integrate(frame_of(depth))).positions
    assert_allclose(points[:, 2], 2.0, atol=COARSE.voxel_size_m)
    assert points[:, 0].min() > 2.0 * (100 - 79.5) / 140 - COARSE.voxel_size_m


@pytest.mark.parametrize("kind", ["a few stray readings", "all at the far limit"])
def test_a_frame_with_hardly_any_depth_in_range_changes_nothing_or_is_unusable(kind: str) -> None:
    """Open3D looks for blocks at every fourth pixel only, short of the limit, and fails where it finds none."""
    depth = np.zeros((120, 160)) if kind == "a few stray readings" else np.full((120, 160), COARSE.depth_max_m)
    if kind == "a few stray readings":
        depth[1::8, 2::8] = 1.5
    voxels = VoxelMap(COARSE)
    try:
        assert len(voxels.integrate(frame_of(depth))) == voxels.n_blocks
    except UnusableFrame:
        assert voxels.n_blocks == 0


def test_integrate_names_the_blocks_it_touched_in_order() -> None:
    voxels = VoxelMap(COARSE)
    first = voxels.integrate(frame_of(np.full((120, 160), 1.5)))
    second = voxels.integrate(frame_of(np.full((120, 160), 3.5)))
    both = np.unique(np.concatenate([first, second]), axis=0)
    assert np.array_equal(first, np.unique(first, axis=0))
    assert np.array_equal(voxels.pages.all()[0], both)
    assert voxels.n_blocks == len(both)
    changed = first * 16 * COARSE.voxel_size_m
    assert (
        (changed[:, 2] <= 1.5 + voxels.settings.truncation_m)
        & (changed[:, 2] + 0.64 >= 1.5 - voxels.settings.truncation_m)
    ).all()


def test_memory_is_that_of_the_attributes() -> None:
    voxels = fused_plane()
    held = sum(view.nbytes for name in ATTRIBUTES for view in voxels.pages.views(name))
    assert voxels.memory_bytes == held
    assert voxels.n_blocks <= held // (BLOCK_VOXELS * 48)


def random_votes(seed: int, n_votes: int = 12) -> list[tuple[Cells, np.ndarray]]:
    """Passes of votes for 0 to 5 on cells of the plane, and on some that no map has."""
    rng = np.random.default_rng(seed)
    surface = np.concatenate([look(frame).cells.coordinates for frame in plane_frames()])
    found = []
    for _ in range(n_votes):
        chosen = rng.choice(len(surface), 300, replace=False)
        cells = cells_at([*surface[chosen], [500, 500, 500], [-900, 3, 4]])
        found.append((cells, rng.integers(0, 6, len(cells)).astype(np.int32)))
    return found


def vote_all(voxels: VoxelMap, passes: list[tuple[Cells, np.ndarray]]) -> None:
    voxels.admit(5)
    for cells, ids in passes:
        voxels.vote(cells, ids)


def slow_tallies(passes: list[tuple[Cells, np.ndarray]]) -> dict[tuple[int, ...], Counter[int]]:
    tallies: dict[tuple[int, ...], Counter[int]] = {}
    for cells, ids in passes:
        for cell, vote in zip(map(tuple, cells.coordinates.tolist()), ids.tolist(), strict=True):
            tallies.setdefault(cell, Counter()).update([vote] if vote and abs(cell[0]) < 400 else [])
    return tallies


ROOMY = COARSE.model_copy(update={"histogram_slots": 6})


def test_votes_and_labels_are_those_of_a_slow_count(device: str) -> None:
    voxels, passes = fused_plane(device, ROOMY), random_votes(1)
    vote_all(voxels, passes)
    tallies = slow_tallies(passes)
    cells = cells_at(sorted(tallies))
    expected = [tallies[cell] for cell in map(tuple, cells.coordinates.tolist())]
    assert histograms(voxels, cells) == [dict(tally) for tally in expected]
    winners = [min((-n, i) for i, n in tally.items())[1] if tally else 0 for tally in expected]
    assert voxels.labels_at(cells).tolist() == winners
    assert len(set(winners)) == 6


def test_label_counts_of_groups_are_those_of_a_slow_count(device: str) -> None:
    voxels, passes = fused_plane(device), random_votes(2)
    vote_all(voxels, passes)
    cells = passes[0][0]
    labels = voxels.labels_at(cells)
    rng = np.random.default_rng(0)
    group, cell = rng.integers(0, 7, 900).astype(np.int32), rng.integers(0, len(cells), 900).astype(np.int32)
    counted = Counter((int(g), int(labels[c])) for g, c in zip(group, cell, strict=True))
    expected = {pair: n for pair, n in counted.items() if pair[1]}
    assert voxels.count_labels(labels, group, cell) == expected
    nothing = np.zeros(0, np.int32)
    assert voxels.count_labels(labels, nothing, nothing) == {}


def test_cells_the_map_does_not_have_are_nobodys() -> None:
    voxels = fused_plane()
    voxels.admit(1)
    before = voxels.n_blocks
    far = cells_at([[1000, 0, 0], [0, 0, -1000]])
    voxels.vote(far, np.ones(2, np.int32))
    assert voxels.labels_at(far).tolist() == [0, 0]
    assert histograms(voxels, far) == [{}, {}]
    assert voxels.n_blocks == before


def test_fusing_ids_is_as_if_the_survivor_had_been_voted_for_from_the_start(device: str) -> None:
    passes = random_votes(3)
    lazy, direct = fused_plane(device, ROOMY), fused_plane(device, ROOMY)
    vote_all(lazy, passes[:6])
    lazy.replace(5, 2)
    vote_all(lazy, passes[6:9])
    lazy.replace(2, 1)  # and with it what was 5
    vote_all(lazy, [(cells, np.where(np.isin(ids, (2, 5)), 1, ids)) for cells, ids in passes[9:]])
    lazy.settle()
    vote_all(direct, [(cells, np.where(np.isin(ids, (2, 5)), 1, ids)) for cells, ids in passes])
    cells = cells_at(sorted(slow_tallies(passes)))
    assert histograms(lazy, cells) == histograms(direct, cells)
    assert lazy.labels_at(cells).tolist() == direct.labels_at(cells).tolist()
    stored = contents(lazy)
    assert set(np.unique(stored["ids"])) == set(np.unique(stored["label"])) == {0, 1, 3, 4}


def test_a_forgotten_id_leaves_its_voxels_to_the_next_best() -> None:
    voxels = fused_plane()
    cells = look(plane_frames()[0]).cells
    here, there = np.full(len(cells), 1, np.int32), np.full(len(cells), 2, np.int32)
    vote_all(voxels, [(cells, here), (cells, there), (cells, there)])
    known = voxels.labels_at(cells) == 2
    assert known.float().mean() > 0.99
    voxels.replace(2, 0)
    assert not (voxels.labels_at(cells) == 2).any()
    voxels.settle()
    assert (voxels.labels_at(cells)[known] == 1).all()
    assert histograms(voxels, cells)[0] == {1: 1}


def test_settling_a_settled_map_changes_nothing() -> None:
    voxels = fused_plane()
    vote_all(voxels, random_votes(4))
    before = contents(voxels)
    voxels.settle()
    assert all(np.array_equal(before[name], now) for name, now in contents(voxels).items())


def test_votes_survive_growth(device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Many small pages hold bit for bit what one large one does."""
    walls = [frame_of(np.full((120, 160), z), pose((0.3 * z, 0, 0))) for z in (0.7, 1.5, 2.3, 3.1)]
    maps: list[dict[str, np.ndarray]] = []
    pages: list[int] = []
    for blocks in (2, 256):
        monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", blocks)
        voxels = VoxelMap(COARSE, device)
        voxels.admit(len(walls))
        for number, wall in enumerate(walls, start=1):
            voxels.integrate(wall)
            voxels.vote(look(wall).cells, np.full(len(look(wall).cells), number, np.int32))
        pages.append(len(voxels.pages.views("weight")))
        maps.append(contents(voxels))
    assert pages[0] > 20
    assert pages[1] == 1
    assert same_contents(*maps)
    assert set(np.unique(maps[0]["label"])) == {0, 1, 2, 3, 4}


def test_allocating_blocks_keeps_what_is_there_and_adds_empty_voxels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 4)
    voxels = fused_plane()
    vote_all(voxels, random_votes(5))
    before = contents(voxels)
    new = np.array([[50 + i, 7, 7] for i in range(80)], np.int32)
    voxels.allocate(new)
    after = contents(voxels)
    is_new = after["keys"][:, 0] >= 50
    assert np.count_nonzero(is_new) == 80
    for name, values in after.items():
        assert np.array_equal(values[~is_new], before[name]), name
        assert name == "keys" or not values[is_new].any(), name


def test_positions_are_where_the_cells_are(device: str) -> None:
    voxels = fused_plane(device)
    cells = look(plane_frames()[1]).cells
    addresses, known = voxels._addresses(cells)
    assert len(known) == len(cells)
    assert_allclose(voxels.pages.positions(addresses).cpu().numpy(), cells.points, atol=1e-5)
