"""The cached surface, renewed only where something changed, against one that is always extracted anew."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal

import razer.tracking.panoptic_integrator
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.config import MapperConfig
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.volume.blocks.block_pages import PAGE_BLOCKS
from razer.volume.space_carving import carve
from razer.volume.surface_cache import SurfaceCache, SurfaceVoxels, points_by_instance
from razer.volume.voxel_map import VoxelMap
from razer.volume.won_shares import won_shares
from tests.support.scenes import COARSE, cells_at, frame_of, look

SHAPE = (120, 160)


def wall(distance_m: float) -> VoxelMap:
    volume = VoxelMap(COARSE)
    volume.admit(3)
    see(volume, distance_m)
    return volume


def see(volume: VoxelMap, distance_m: float, times: int = 3) -> None:
    for _ in range(times):
        volume.integrate(frame_of(np.full(SHAPE, distance_m)))


def assert_is_all(known: SurfaceCache, volume: VoxelMap) -> None:
    found = known.around(range(volume.newest_id + 1))
    everything = SurfaceVoxels.at(volume, volume.surface_addresses())
    ours, theirs = (torch.argsort(of.addresses) for of in (found, everything))
    for part in ("addresses", "labels", "ids", "counts"):
        assert_array_equal(getattr(found, part)[ours].cpu(), getattr(everything, part)[theirs].cpu())


def test_a_volume_is_all_new_at_first_and_nothing_is_after_that() -> None:
    volume, known = wall(1.5), SurfaceCache()
    assert known.renew(volume) is None
    assert len(known.around([0]).addresses) > 100
    assert known.renew(volume) == set()
    assert_is_all(known, volume)


@pytest.mark.parametrize("change", ["integrate", "vote", "carve", "amplify", "grow"])
def test_whatever_changes_is_seen(change: str) -> None:
    volume, known = wall(1.5), SurfaceCache()
    place = np.array([[round(0.5 / COARSE.voxel_size_m), 0, round(1.5 / COARSE.voxel_size_m)]])
    for _ in range(3):
        volume.vote(cells_at(place), np.ones(1, np.int32))
    known.renew(volume)
    if change == "integrate":
        see(volume, 1.2, times=4)
    elif change == "vote":
        for _ in range(5):
            volume.vote(cells_at(place), np.full(1, 2, np.int32))
    elif change == "carve":
        for _ in range(4):
            carve(volume, look(frame_of(np.full(SHAPE, 3.0))))
    elif change == "amplify":
        volume.amplify(0.5)
    else:
        many = np.arange(3 * PAGE_BLOCKS, dtype=np.int32)[:, None] + np.array([[100, 0, 0]], np.int32)
        volume.allocate(many)
        volume.vote(cells_at(place), np.ones(1, np.int32))
    changed = known.renew(volume)
    assert_is_all(known, volume)
    assert changed is None or 1 in changed or change == "integrate"
    if change == "vote":
        assert changed == {0, 1, 2}
    if change == "grow":
        assert changed == {0, 1}


def test_another_volume_is_all_new() -> None:
    known = SurfaceCache()
    known.renew(wall(1.5))
    other = wall(1.0)
    assert known.renew(other) is None
    assert_is_all(known, other)


def test_points_of_instances_follow_fusions() -> None:
    volume = wall(1.5)
    layer = round(1.5 / COARSE.voxel_size_m)
    for x, owner in ((-3, 1), (0, 2), (3, 3)):
        volume.vote(cells_at([[x, 0, layer], [x, 1, layer]]), np.full(2, owner, np.int32))
    volume.replace(3, 1)
    surface = SurfaceVoxels.at(volume, volume.surface_addresses())
    points = points_by_instance(volume, surface, [2, 1])
    assert {i: len(p) for i, p in points.items()} == {1: 4, 2: 2}
    assert points[1][:, 0] == pytest.approx(np.repeat([-3, 3], 2) * COARSE.voxel_size_m)
    assert points_by_instance(volume, surface, []) == {}


def test_what_lies_around_an_instance_tells_of_it_what_all_of_the_surface_does() -> None:
    rng = np.random.default_rng(0)
    volume, known = wall(1.5), SurfaceCache()
    volume.admit(6)
    cells = look(frame_of(np.full(SHAPE, 1.5))).cells
    of_block = rng.integers(1, 6, (len(cells.block_keys), 2))
    for number in range(8):
        volume.vote(cells, rng.permuted(of_block, axis=1)[cells.block, 0].astype(np.int32))
        if number == 4:
            volume.replace(5, 2)
            volume.replace(3, 0)
        known.renew(volume)
        everything = SurfaceVoxels.at(volume, volume.surface_addresses())
        shares = won_shares(volume, everything)
        for instance in (1, 2, 3, 4, 6):
            near = known.around([instance])
            assert len(near.addresses) < len(everything.addresses)
            ours, theirs = (points_by_instance(volume, of, [instance])[instance] for of in (near, everything))
            assert_array_equal(ours, theirs)
            assert won_shares(volume, near).get(instance) == shares.get(instance)


class _Anew(SurfaceCache):
    """Forgets what it knows each time."""

    def renew(self, volume: VoxelMap) -> set[int] | None:
        volume.take_touched()
        self.volume = volume
        return None

    def around(self, instances: Collection[int]) -> SurfaceVoxels:
        return SurfaceVoxels.at(self.volume, self.volume.surface_addresses())


@pytest.mark.full
def test_tracks_are_the_same_as_if_all_of_the_surface_were_taken_each_time(monkeypatch) -> None:
    room = SyntheticScene("room", 2, 90, 320, 240, sensor=SensorModel.kinect())
    tracks = []
    for kind in (SurfaceCache, _Anew):
        monkeypatch.setattr(razer.tracking.panoptic_integrator, "SurfaceCache", kind)
        mapper = Mapper(MapperConfig(), OracleSegmenter("full", seed=1), OracleEmbedder("full", seed=1))
        for index in range(len(room)):
            mapper.step(room[index])
        tracks.append({t.id: (t.n_voxels, t.won_share, t.hits, *t.box.center, *t.box.extent) for t in mapper.tracks})
    assert tracks[0].keys() == tracks[1].keys()
    for track_id, state in tracks[0].items():
        assert state == pytest.approx(tracks[1][track_id], abs=1e-6)
