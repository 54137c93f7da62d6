"""The whole method on a CUDA device beside the same on the CPU."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig, VoxelSettings
from razer.config.reintegration import ReintegrationSettings
from razer.frame import Frame
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.panoptic_map import PanopticMap

pytestmark = pytest.mark.gpu
N_FRAMES = 60


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    room = SyntheticRoom(seed=0, n_frames=N_FRAMES, width=320, height=240, noise=True)
    return [room[i] for i in range(N_FRAMES)]


def mapped(frames: list[Frame], device: str, *, corrects: bool) -> PanopticMap:
    """The room mapped with imperfect masks; if asked for, with poses that are corrected at the end."""
    settings = MapperConfig(
        voxels=VoxelSettings(voxel_size_m=0.03), reintegration=ReintegrationSettings(enabled=corrects)
    )
    mapper = Mapper(settings, OracleSegmenter("full", seed=1), OracleEmbedder("full", seed=1), device=device)
    for frame in frames:
        shift = np.eye(4)
        shift[0, 3] = 0.1 * frame.index / N_FRAMES if corrects else 0.0
        mapper.step(frame.at(shift @ frame.pose))
    if corrects:
        mapper.move({frame.index: frame.pose for frame in frames})
    return mapper.finish()


@pytest.mark.parametrize("corrects", [False, True])
def test_instances_labels_and_surface_are_the_same(frames: list[Frame], cuda: str, corrects: bool) -> None:
    one, other = (mapped(frames, device, corrects=corrects) for device in ("CPU:0", cuda))
    assert len(one.objects) > 10
    assert [item.id for item in one.objects] == [item.id for item in other.objects]
    for a, b in zip(one.objects, other.objects, strict=True):
        assert (a.class_name, a.observations, a.first_frame) == (b.class_name, b.observations, b.first_frame)
        np.testing.assert_allclose(a.box.center, b.box.center, atol=0.03)
        np.testing.assert_allclose(a.score, b.score, atol=0.02)
    distance_m, nearest = cKDTree(one.mesh.vertices).query(other.mesh.vertices)
    assert np.mean(distance_m < 1e-3) > 0.998
    assert np.mean(one.mesh.instances[nearest] == other.mesh.instances) > 0.995


def test_a_map_saved_from_the_device_is_opened_without_it(frames: list[Frame], cuda: str, tmp_path) -> None:
    import razer

    panoptic = mapped(frames[:20], cuda, corrects=False)
    panoptic.save(tmp_path / "map")
    opened = razer.load_map(tmp_path / "map")
    assert [item.id for item in opened.objects] == [item.id for item in panoptic.objects]
    assert np.array_equal(opened.mesh.instances, panoptic.mesh.instances)
