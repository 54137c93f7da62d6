"""The volume on a CUDA device beside the same on the CPU: fusion, votes, carving, surface and file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import VoxelSettings
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame
from razer.storage.volume_npz import load_voxels, save_voxels
from razer.volume.box_voting import vote_in_boxes
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.space_carving import carve
from razer.volume.support_pruning import support_ratios
from razer.volume.surface_cache import SurfaceCache, points_by_instance
from razer.volume.voxel_map import VoxelMap
from razer.volume.won_shares import won_shares
from tests.support.scenes import axis_box, contents, detection, look, same_contents

pytestmark = pytest.mark.gpu
CPU = "CPU:0"
SETTINGS = VoxelSettings(voxel_size_m=0.03, truncation_voxels=4.0, depth_max_m=5.0)
# A voxel on the border of two pixels may be given to either: the devices round the last bit of a product differently.
MOST = 0.9995


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    room = SyntheticRoom(seed=2, n_frames=24, width=320, height=240, noise=True)
    return [room[i] for i in range(len(room))]


@pytest.fixture(scope="module")
def both(frames: list[Frame], cuda: str) -> tuple[VoxelMap, VoxelMap]:
    """The map of the room on the CPU, and on the CUDA device."""
    return mapped(frames, CPU), mapped(frames, cuda)


def mapped(frames: list[Frame], device: str, change: Callable[[Frame], Frame] = lambda frame: frame) -> VoxelMap:
    """All frames fused, voted on with their true ids, and carved with; now and then two instances are fused."""
    voxels = VoxelMap(SETTINGS, device)
    voxels.admit(max(int(frame.instance_ids.max()) for frame in frames))
    for frame in frames:
        surface = look(frame, SETTINGS)
        voxels.integrate(change(frame), surface)
        vote_truth(voxels, frame, surface)
        if frame.index % 8 == 7:
            carve(voxels, surface)
            voxels.replace(3 + frame.index // 8, 2)
    return voxels


def vote_truth(voxels: VoxelMap, frame: Frame, surface: ObservedSurface) -> None:
    row, column, z, on_image = surface.cell_pixels
    seen = frame.instance_ids[:: surface.stride, :: surface.stride][row, column]
    near = on_image & (np.abs(surface.depth[row, column] - z) < 0.06)
    ids = np.where(near, seen, 0).astype(np.int32)
    voxels.vote(surface.cells, ids, np.unique(ids[ids > 0]), near)


def agreeing(one: np.ndarray, other: np.ndarray, atol: float = 0.0) -> float:
    """The share of voxels (B, 4096, channels), of those that hold anything, that are the same in two maps."""
    holds = (one != 0).any(axis=-1) | (other != 0).any(axis=-1)
    assert holds.sum() > 10_000
    return float((np.abs(one.astype(np.float64) - other) <= atol).all(axis=-1)[holds].mean())


@pytest.mark.parametrize(
    ("name", "atol"), [("tsdf", 1e-3), ("weight", 1e-5), ("color", 0.5), ("label", 0.0), ("ids", 0.0), ("counts", 0.0)]
)
def test_voxels_are_the_same(both: tuple[VoxelMap, VoxelMap], name: str, atol: float) -> None:
    one, other = (contents(voxels) for voxels in both)
    assert np.array_equal(one["keys"], other["keys"])
    assert agreeing(one[name], other[name], atol) > MOST


def test_colour_that_is_hidden_is_left_out_alike(frames: list[Frame], cuda: str) -> None:
    def half_in_colour(frame: Frame) -> Frame:
        seen = np.zeros(frame.depth.shape, bool)
        seen[:, 40 * (frame.index % 4) :] = True
        return replace(frame, has_color=seen, rgb=np.where(seen[..., None], frame.rgb, np.uint8(0)))

    one, other = (contents(mapped(frames, device, half_in_colour)) for device in (CPU, cuda))
    assert np.array_equal(one["keys"], other["keys"])
    assert agreeing(one["weight"], other["weight"], 1e-5) > MOST
    assert agreeing(one["color"], other["color"], 0.5) > MOST


def test_the_mesh_is_the_same_surface_with_the_same_labels(both: tuple[VoxelMap, VoxelMap]) -> None:
    for voxels in both:
        voxels.settle()
    one, other = (extract_mesh(voxels) for voxels in both)
    assert len(other.vertices) == pytest.approx(len(one.vertices), rel=1e-3)
    assert len(other.triangles) == pytest.approx(len(one.triangles), rel=1e-3)
    distance_m, nearest = cKDTree(one.vertices).query(other.vertices)
    assert np.mean(distance_m < 1e-4) > 0.999
    assert np.mean(one.instances[nearest] == other.instances) > 0.999
    assert len({*one.instances.tolist()}) > 5


def test_points_and_shares_of_each_instance_are_the_same(both: tuple[VoxelMap, VoxelMap]) -> None:
    shares, counts, supports = [], [], []
    for voxels in both:
        cache = SurfaceCache()
        cache.renew(voxels)
        known = range(1, voxels.newest_id + 1)
        surface = cache.around(known)
        shares.append(won_shares(voxels, surface))
        counts.append({i: len(points) for i, points in points_by_instance(voxels, surface, known).items()})
        supports.append(support_ratios(voxels, {i: axis_box((0, 0, 0), (1, 1, 1)) for i in known}))
    assert shares[0] == pytest.approx(shares[1], rel=2e-3)
    assert counts[0] == pytest.approx(counts[1], rel=2e-3, abs=2)
    assert supports[0] == pytest.approx(supports[1], rel=2e-3, abs=1e-4)
    assert sum(counts[0].values()) > 5_000


def test_votes_by_boxes_are_the_same(frames: list[Frame], cuda: str) -> None:
    votes = []
    for device in (CPU, cuda):
        voxels, surface = VoxelMap(SETTINGS, device), look(frames[0], SETTINGS)
        voxels.integrate(frames[0], surface)
        voxels.admit(2)
        centre = surface.cells.points.mean(axis=0)
        boxes = {1: axis_box(centre, (2.0, 2.0, 2.0)), 2: axis_box(centre + 0.5, (1.5, 1.0, 1.0))}
        seen = [replace(detection(box), pixels=np.arange(50, dtype=np.int32)) for box in boxes.values()]
        vote_in_boxes(voxels, surface, seen, np.array([1, 2], np.int32), boxes)
        votes.append(contents(voxels))
    assert agreeing(votes[0]["ids"], votes[1]["ids"]) > MOST
    assert agreeing(votes[0]["counts"], votes[1]["counts"]) > MOST


@pytest.mark.parametrize("way", ["CUDA to CPU", "CPU to CUDA", "CUDA to CUDA"])
def test_a_saved_volume_loads_on_the_other_device_bit_for_bit(
    both: tuple[VoxelMap, VoxelMap], cuda: str, way: str, tmp_path: Path
) -> None:
    source, target = way.split(" to ")
    voxels = both[source == "CUDA"]
    save_voxels(tmp_path / "map.npz", voxels)
    loaded = load_voxels(tmp_path / "map.npz", cuda if target == "CUDA" else CPU)
    assert str(loaded.device) == (cuda if target == "CUDA" else CPU)
    # Voxels that hold nothing of weight or votes are not saved.
    kept, now = contents(voxels), contents(loaded)
    used = (kept["weight"] > 0)[..., 0] | (kept["counts"] > 0).any(axis=-1)
    assert same_contents(
        now,
        {name: np.where(used[..., None], v, 0).astype(v.dtype) if name != "keys" else v for name, v in kept.items()},
    )


def test_the_same_frames_give_the_same_volume_twice(frames: list[Frame], cuda: str) -> None:
    assert same_contents(*(contents(mapped(frames[:8], cuda)) for _ in range(2)))
