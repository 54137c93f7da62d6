"""Pages of blocks: nothing moves as they grow, and addresses of all pages are read and written alike."""

from __future__ import annotations

import numpy as np
import open3d.core as o3c
import pytest
import torch
from numpy.testing import assert_allclose

import razer.volume.blocks.block_pages
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.volume.blocks.block_pages import BlockPages
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import ATTRIBUTES, COARSE, frame_of, pose


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 8)


def line(n: int, start: int = 0) -> np.ndarray:
    """Keys (n, 3) of blocks in a row."""
    return np.array([[start + i, 0, 0] for i in range(n)], np.int32)


def pages_of(n_blocks: int) -> BlockPages:
    pages = BlockPages(COARSE, o3c.Device("CPU:0"), torch.device("cpu"))
    pages.add(line(n_blocks))
    return pages


def test_what_is_stored_stays_where_it_is_as_the_map_grows() -> None:
    pages = pages_of(20)
    held = {name: [view.data_ptr() for view in pages.views(name)] for name in ATTRIBUTES}
    rows = pages.find(line(20)).tolist()
    pages.add(line(60))
    assert {name: [view.data_ptr() for view in pages.views(name)][:3] for name in ATTRIBUTES} == held
    assert pages.find(line(20)).tolist() == rows
    assert len(pages.views("weight")) == 8  # of 8 blocks each
    assert len(pages) == 60
    assert len({*pages.find(line(60)).tolist()}) == 60


def test_frames_that_see_full_pages_do_not_make_them_larger(monkeypatch: pytest.MonkeyPatch) -> None:
    """Open3D's `integrate` makes a grid larger where it is given more blocks than are free, be they new or not."""
    for name in ("SPARE_ROWS", "CUDA_SPARE_ROWS"):
        monkeypatch.setattr(razer.volume.blocks.block_pages, name, 2)
    voxels = VoxelMap(COARSE)
    for x in np.linspace(0, 1.5, 6):
        at = pose((x, 0, 0))
        for _ in range(2):
            voxels.integrate(frame_of(np.full((120, 160), 1.5), at))
    assert voxels.n_blocks > 2 * 8
    rows = {view.shape[0] for view in voxels.pages.views("weight")}
    assert rows == {(8 + 2) * BLOCK_VOXELS}


def test_reading_and_writing_across_pages_is_as_with_one_array() -> None:
    rng = np.random.default_rng(0)
    pages = pages_of(30)
    everywhere = torch.from_numpy(rng.permutation(30 * BLOCK_VOXELS)[:5000])
    addresses = pages.find(line(30))[everywhere // BLOCK_VOXELS] * BLOCK_VOXELS + everywhere % BLOCK_VOXELS
    label, color = torch.arange(5000, dtype=torch.int32)[:, None], torch.rand(5000, 3)
    pages.write(addresses, label=label, color=color)
    some = torch.from_numpy(rng.integers(0, 5000, 700))
    found = pages.read(addresses[some], "color", "label", "weight")
    assert torch.equal(found[0], color[some])
    assert torch.equal(found[1], label[some])
    assert not found[2].any()
    pages.write(addresses[some[:10]], label=torch.full((10, 1), -1, dtype=torch.int32))
    changed = set(some[:10].tolist())
    expected = [-1 if i in changed else i for i in range(5000)]
    assert pages.read(addresses, "label")[0][:, 0].tolist() == expected
    assert sum(int((view != 0).sum()) for view in pages.views("label")) == 5000 - (0 not in changed)


def test_selected_addresses_are_in_the_order_of_the_blocks_asked_for() -> None:
    pages = pages_of(30)
    rows = pages.find(line(30)[::-1].copy())
    addresses = rows[[3, 11, 12, 29]] * BLOCK_VOXELS + torch.tensor([7, 5, 4000, 0])
    pages.write(addresses, weight=torch.ones(4, 1), tsdf=torch.full((4, 1), 0.5))
    chosen = pages.select(rows, lambda weight, tsdf: (weight * tsdf)[..., 0] == 0.5, "weight", "tsdf")
    assert torch.equal(chosen, addresses)
    assert torch.equal(pages.select(rows[10:12], lambda weight: weight[..., 0] > 0, "weight"), addresses[1:2])
    assert len(pages.select(rows[:0], lambda weight: weight[..., 0] > 0, "weight")) == 0
    assert torch.equal(
        pages.blocks(rows, "weight").flatten().nonzero().flatten() // BLOCK_VOXELS, torch.tensor([3, 11, 12, 29])
    )


def test_positions_are_those_of_the_keys() -> None:
    pages = pages_of(30)
    rows = pages.find(line(30))
    corner = pages.positions(rows * BLOCK_VOXELS + 1 + 16 * 2 + 256 * 3)
    expected = (line(30) * 16 + [1, 2, 3]) * COARSE.voxel_size_m
    assert_allclose(corner.numpy(), expected, rtol=1e-6)
