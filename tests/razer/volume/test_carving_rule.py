"""Space carving against its rule, applied literally to every voxel round a camera."""

from __future__ import annotations

import numpy as np
import pytest

import razer.volume.blocks.block_pages
from razer.detection.observed_surface import BLOCK, ObservedSurface
from razer.frame import Intrinsics
from razer.geometry import inverse, transform_points
from razer.volume.space_carving import _in_view, carve
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, contents, fill, frame_of, look, pose

EDGE, KEPT = 2, 0.125  # strided pixels around a voxel; the share of weight that is kept
SURFACE_TSDF = 0.1875  # three quarters of a voxel, by the truncation of four
N_INSTANCES, SLOTS = 5, 4
# Neither square nor centred, so that rows are not columns and no side is another.
CAMERA = Intrinsics(160, 120, 150.0, 120.0, 60.0, 72.0)
Contents = dict[str, np.ndarray]


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 160)


def surrounded(rng: np.random.Generator) -> VoxelMap:
    """Blocks on all sides of the origin, 1.3 m and more each way, with anything in them."""
    voxels = VoxelMap(COARSE)
    voxels.admit(N_INSTANCES)
    keys = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.int32)
    voxels.allocate(keys)
    shape = (len(keys), BLOCK**3)
    counts = rng.choice([0, 0, 1, 7, 8, 9, 40, 30_000], (*shape, SLOTS)).astype(np.int16)
    ids = np.where(counts > 0, rng.permuted(np.tile(np.arange(1, SLOTS + 1), (*shape, 1)), axis=2), 0).astype(np.int32)
    fill(
        voxels,
        tsdf=rng.choice([-1, -0.5, -0.1, 0, 0.18, SURFACE_TSDF, 0.2, 1], (*shape, 1)).astype(np.float32),
        weight=rng.choice([0, 0.5, 1, 7, 8, 9, 50], (*shape, 1)).astype(np.float32),
        color=rng.integers(0, 255, (*shape, 3)).astype(np.float32),
        ids=ids,
        counts=counts,
        label=winners(ids, counts),
    )
    return voxels


def winners(ids: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Most votes first, then the lowest id; 0 where nobody has any."""
    rank = np.where(counts > 0, counts.astype(np.int64) * 100 - ids, -1)
    best = np.take_along_axis(ids, rank.argmax(axis=2)[..., None], axis=2)
    return np.where(rank.max(axis=2, keepdims=True) > 0, best, 0)


def free_voxels(keys: np.ndarray, surface: ObservedSurface) -> tuple[np.ndarray, np.ndarray]:
    """Which voxels (B, 4096) the frame looks through, and where that does not hang on rounding."""
    place = np.arange(BLOCK**3)
    inside = np.stack([place % BLOCK, place // BLOCK % BLOCK, place // BLOCK**2], axis=-1)
    points = (keys[:, None] * BLOCK + inside) * COARSE.voxel_size_m
    x, y, z = np.moveaxis(transform_points(inverse(surface.world_from_camera), points.reshape(-1, 3)), 1, 0)
    matrix = surface.matrix
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = matrix[0, 0] * x / z + matrix[0, 2], matrix[1, 1] * y / z + matrix[1, 2]
    height, width = surface.depth.shape
    column, row = np.nan_to_num([np.round(u), np.round(v)], posinf=-9, neginf=-9).astype(int)
    nearest = np.zeros(len(z))
    on_image = (z > 0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    for i in np.flatnonzero(on_image):
        rows, columns = (slice(max(at - EDGE, 0), at + EDGE + 1) for at in (row[i], column[i]))
        nearest[i] = surface.depth[rows, columns].min()
    gap = nearest - z - COARSE.truncation_m
    is_sure = (np.abs(u % 1 - 0.5) > 1e-3) & (np.abs(v % 1 - 0.5) > 1e-3) & (np.abs(gap) > 1e-5) & (np.abs(z) > 1e-5)
    shape = (len(keys), BLOCK**3)
    return (on_image & (gap > 0)).reshape(shape), is_sure.reshape(shape)


def carved(held: Contents, free: np.ndarray) -> Contents:
    """What is left after a pass, voxel by voxel."""
    result = {name: values.copy() for name, values in held.items()}
    weight, tsdf = held["weight"][..., 0], held["tsdf"][..., 0]
    is_near = tsdf <= SURFACE_TSDF
    hit = free & (weight > 0) & (is_near | (held["label"][..., 0] > 0))
    result["weight"][hit & is_near] *= KEPT
    result["counts"][hit] //= 8
    for name in ("weight", "tsdf", "color", "ids", "counts"):
        result[name][hit & is_near & (weight * KEPT < 1)] = 0
    result["ids"][hit] = np.where(result["counts"][hit] > 0, result["ids"][hit], 0)
    result["label"][hit] = winners(result["ids"], result["counts"])[hit]
    return result


def depth_of_patches(rng: np.random.Generator) -> np.ndarray:
    """Readings from 0.8 to 2 m in patches, one of which has none."""
    patches = rng.permutation([0, 0.8, 0.8, 1.1, 1.1, 1.1, 1.5, 1.5, 1.5, 2, 2, 2]).reshape(3, 4)
    return np.kron(patches, np.ones((40, 40)))


@pytest.mark.parametrize(("seed", "turn_deg"), [(0, (0, 0, 0)), (1, (20, 140, 10)), (2, (-80, 10, 60))])
def test_every_voxel_round_a_camera_follows_the_rule(seed: int, turn_deg: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(seed)
    voxels = surrounded(rng)
    at = pose((0.03, -0.05, 0.02), turn_deg)
    surface = look(frame_of(depth_of_patches(rng), at, camera=CAMERA))
    held = contents(voxels)
    carve(voxels, surface)
    free, is_sure = free_voxels(held["keys"], surface)
    assert 8_000 < np.count_nonzero(free) < 0.2 * free.size
    assert is_sure.mean() > 0.99
    expected, found = carved(held, free), contents(voxels)
    for name in ("weight", "tsdf", "color", "ids", "counts", "label"):
        np.testing.assert_array_equal(found[name][is_sure], expected[name][is_sure], err_msg=name)


def is_within_an_edge_of_the_frustum(key: np.ndarray, surface: ObservedSurface) -> bool:
    """Whether the centre of a block is, or is less than a block's edge outside, along each axis of the camera."""
    edge_m = BLOCK * COARSE.voxel_size_m
    x, y, z = transform_points(inverse(surface.world_from_camera), (key[None] + 0.5) * edge_m)[0]
    (fx, _, cx), (_, fy, cy) = surface.matrix[:2]
    height, width = surface.depth.shape
    if not -edge_m < z < surface.depth.max() + edge_m:
        return False
    z = max(z, 0.0)
    left, right, top, bottom = -cx / fx * z, (width - cx) / fx * z, -cy / fy * z, (height - cy) / fy * z
    return left - edge_m <= x <= right + edge_m and top - edge_m <= y <= bottom + edge_m


@pytest.mark.parametrize("turn_deg", [(0, 0, 0), (20, 140, 10), (-80, 10, 60), (15, -75, -40)])
def test_blocks_far_from_the_frustum_are_not_looked_at(turn_deg: tuple[float, float, float]) -> None:
    surface = look(frame_of(np.full((120, 160), 2.5), pose((0.3, -0.1, 0.2), turn_deg), camera=CAMERA))
    keys = np.stack(np.meshgrid(*[np.arange(-8, 8)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.int32)
    expected = [is_within_an_edge_of_the_frustum(key, surface) for key in keys]
    assert _in_view(keys, VoxelMap(COARSE), surface).tolist() == expected
    assert 100 < sum(expected) < 500
