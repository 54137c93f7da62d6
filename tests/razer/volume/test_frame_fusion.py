"""Fusion of frames whose colour camera does not see all that depth shows: no voxel grows dark of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

import razer.volume.blocks.block_pages
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, frame_of, plane_depth, pose

NORMAL, DISTANCE_M = np.array([0.0, 0.0, 1.0]), 1.5
COLOR = (200, 120, 40)


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for what these maps need: whole attributes are quicker to compare."""
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


def wall(index: int, has_color: bool | None) -> Frame:
    """A wall of one colour, seen in colour or not; None = the frame says nothing of it."""
    frame = frame_of(plane_depth(pose(), NORMAL, DISTANCE_M), pose(), index=index)
    rgb = np.full_like(frame.rgb, COLOR) if has_color is not False else np.zeros_like(frame.rgb)
    seen = None if has_color is None else np.full(frame.depth.shape, has_color)
    return replace(frame, rgb=rgb, has_color=seen)


def fused(*seen: bool | None) -> VoxelMap:
    voxels = VoxelMap(COARSE, "CPU:0")
    for index, has_color in enumerate(seen):
        voxels.integrate(wall(index, has_color))
    return voxels


def observed(voxels: VoxelMap) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Distance, weight and colour (0 to 255) of the voxels that were observed."""
    tsdf, weight, color = (torch.cat(voxels.pages.views(name)) for name in ("tsdf", "weight", "color"))
    seen = weight[:, 0] > 0
    return tsdf[seen, 0], weight[seen, 0], color[seen]


def test_geometry_is_the_same_with_and_without_colour() -> None:
    with_color, without = observed(fused(None, None, None)), observed(fused(True, False, False))
    for part in (0, 1):
        torch.testing.assert_close(without[part], with_color[part])


@pytest.mark.parametrize(
    "order", [(True, False, False), (False, False, True), (False, True, False, True), (True, True)]
)
def test_a_voxel_has_the_colour_that_was_seen_of_it(order: tuple[bool, ...]) -> None:
    _, weight, color = observed(fused(*order))
    assert (weight == len(order)).all()
    torch.testing.assert_close(color, torch.tensor(COLOR, dtype=torch.float32).expand_as(color), atol=0.01, rtol=0)


def at_distance(frame: Frame, off_m: float, weight: float) -> Frame:
    return replace(frame, depth=frame.depth + np.float32(off_m), weight=weight)


@pytest.mark.parametrize("has_color", [None, True, False])
def test_a_frame_counts_by_its_weight(has_color: bool | None) -> None:
    """Two frames in full, and one a centimetre farther that counts a quarter: the mean of the distances by weight."""
    alone, mean = VoxelMap(COARSE, "CPU:0"), VoxelMap(COARSE, "CPU:0")
    off_m, weight = 0.01, 0.25
    for voxels in (alone, mean):
        voxels.integrate(wall(0, has_color))
        voxels.integrate(wall(1, has_color))
    mean.integrate(at_distance(wall(2, has_color), off_m, weight))
    (tsdf, counts, _), (shifted, counted, color) = observed(alone), observed(mean)
    inside = (tsdf.abs() < 0.5) & (counts == 2)
    assert len(tsdf) == len(shifted)
    torch.testing.assert_close(counted[inside], counts[inside] + weight)
    expected = off_m * weight / (2 + weight) / (COARSE.truncation_voxels * COARSE.voxel_size_m)
    torch.testing.assert_close((shifted - tsdf)[inside], torch.full_like(tsdf[inside], expected), atol=1e-5, rtol=0.01)
    if has_color is not False:
        torch.testing.assert_close(
            color[inside], torch.tensor(COLOR).float().expand_as(color[inside]), atol=0.01, rtol=0
        )


def test_what_is_seen_with_a_small_weight_alone_lies_where_it_is() -> None:
    voxels, light = VoxelMap(COARSE, "CPU:0"), VoxelMap(COARSE, "CPU:0")
    for index in range(4):
        voxels.integrate(wall(index, None))
        light.integrate(replace(wall(index, None), weight=0.25))
    (tsdf, weight, color), (same, less, tinted) = observed(voxels), observed(light)
    torch.testing.assert_close(same, tsdf)
    torch.testing.assert_close(tinted, color)
    assert (less == weight / 4).all()


@pytest.mark.parametrize("weight", [0.0, -1.0, 1.5])
def test_a_weight_that_is_none_is_refused(weight: float) -> None:
    with pytest.raises(UnusableFrame, match="a weight of"):
        replace(wall(0, None), weight=weight)


def test_what_was_never_seen_in_colour_has_none() -> None:
    assert not observed(fused(False, False))[2].any()


def test_a_hidden_part_takes_nothing_from_the_seen_one() -> None:
    """The left half is hidden in the first frame and seen in the second, the right half the other way round."""
    first, second = wall(0, True), wall(1, True)
    left = np.zeros(first.depth.shape, bool)
    left[:, : left.shape[1] // 2] = True
    voxels = VoxelMap(COARSE, "CPU:0")
    voxels.integrate(replace(first, has_color=~left, rgb=np.where(left[..., None], np.uint8(0), first.rgb)))
    voxels.integrate(replace(second, has_color=left, rgb=np.where(left[..., None], second.rgb, np.uint8(0))))
    _, weight, color = observed(voxels)
    assert (weight == 2).all()
    torch.testing.assert_close(color, torch.tensor(COLOR, dtype=torch.float32).expand_as(color), atol=0.01, rtol=0)


# Cameras with which Open3D, left to itself, finds pixels of the first row or column off the image.
AWKWARD = [Intrinsics(160, 120, f, f, cx, cy) for f, cx, cy in [(134.5, 71.0, 59.0), (145.5, 82.5, 57.5)]]


@pytest.mark.parametrize("camera", AWKWARD)
@pytest.mark.parametrize("device", ["CPU:0", pytest.param("CUDA:0", marks=pytest.mark.gpu)])
def test_voxels_at_the_border_of_the_image_have_the_colour_of_their_pixel(
    camera: Intrinsics, device: str, request: pytest.FixtureRequest
) -> None:
    at = request.getfixturevalue("cuda") if device == "CUDA:0" else device
    frame = frame_of(plane_depth(pose(), NORMAL, DISTANCE_M, camera), pose(), camera=camera)
    v, u = np.mgrid[: camera.height, : camera.width]
    voxels = VoxelMap(COARSE, at)
    rows = voxels.rows_of(voxels.integrate(replace(frame, rgb=np.stack([u, v, 0 * u + 255], -1).astype(np.uint8))))
    addresses = voxels.pages.select(rows, lambda weight: weight[..., 0] > 0, "weight")
    x, y, z = voxels.pages.positions(addresses).cpu().numpy().astype(float).T
    color = voxels.pages.read(addresses, "color")[0].cpu().numpy()
    assert np.abs(color[:, 0] - (camera.fx * x / z + camera.cx)).max() < 1 + 1e-3
    assert np.abs(color[:, 1] - (camera.fy * y / z + camera.cy)).max() < 1 + 1e-3
    np.testing.assert_allclose(color[:, 2], 255, atol=0.01)
