"""A mapper and a source of poses that come back from their saved state go on as if nothing had happened, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from app.checkpoints.map_state import known_map
from app.stored_state.pose_state import known_poses
from app.stored_state.saved_state import tidy
from app.stored_state.state_files import StateWriter, load_state
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.config import MapperConfig
from razer.mapper import Mapper
from slam.config import SlamConfig
from slam.refinement import RefinedPoses
from slam.sparse.solved_poses import SolvedPoses
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem

BEFORE, AFTER = 18, 10
MODELS = {"segmenter": {"name": "oracle"}, "embedder": {"name": "oracle"}}


@pytest.fixture(scope="module")
def frames():
    scene = SyntheticScene("room", 3, 100, 160, 120, sensor=SensorModel.kinect())
    return [scene[i] for i in range(BEFORE + AFTER)]


def mapper_config(**sections):
    return MapperConfig.model_validate({"voxels": {"voxel_size_m": 0.04}, **MODELS, **sections})


def step(mapper, frames, shift_at=None):
    """Map frames; with `shift_at` all poses before that frame are corrected with it."""
    for frame in frames:
        if frame.index == shift_at:
            moved = np.eye(4)
            moved[0, 3] = 0.15
            mapper.move(dict.fromkeys(range(0, shift_at, 3), moved @ frames[0].pose))
        mapper.step(frame)


def digest(mapper):
    panoptic = mapper.finish()
    mesh = panoptic.mesh
    surface = [part.tobytes() for part in (mesh.vertices, mesh.triangles, mesh.instances, mesh.colors)]
    return surface, [
        (o.id, o.class_name, o.score, o.box.center.tolist(), o.box.extent.tolist(), o.n_voxels, o.observations,
         o.embeddings.tobytes(), o.weights.tolist(), o.views, o.class_votes)
        for o in panoptic.objects
    ]  # fmt: skip


@pytest.mark.parametrize(
    "sections",
    [
        pytest.param({}, id="plain", marks=pytest.mark.full),
        pytest.param(
            {"reintegration": {"enabled": True, "frames_per_keyframe": 2, "memory_mb": 1}}, id="poses corrected"
        ),
        pytest.param(
            {"maintenance": {"pruning": "support", "moments": "sums"}}, id="as the paper", marks=pytest.mark.full
        ),
        pytest.param({"granularity": "part"}, id="parts", marks=pytest.mark.full),
    ],
)
def test_a_mapper_goes_on(frames, tmp_path, sections):
    config = mapper_config(**sections)
    corrected = BEFORE - 2 if "reintegration" in sections else None
    mapper = Mapper(config)
    step(mapper, frames[:BEFORE], corrected)
    writer = StateWriter(tmp_path, "map", known_map(mapper.config))
    tidy(tmp_path, writer.save(mapper.state))
    tidy(tmp_path, saved := writer.save(mapper.state))  # nothing changed: it needs what is there

    again = Mapper(mapper_config(**sections))
    again.state = load_state(tmp_path, saved, known_map(again.config))
    for each in (mapper, again):
        step(each, frames[BEFORE:])
    assert again.voxels.n_blocks == mapper.voxels.n_blocks
    assert digest(again) == digest(mapper)


def test_what_did_not_change_takes_no_more_room(frames, tmp_path):
    mapper = Mapper(mapper_config())
    step(mapper, frames[:BEFORE])
    writer = StateWriter(tmp_path, "map", known_map(mapper.config))
    writer.save(mapper.state)
    before = sum(path.stat().st_size for path in tmp_path.glob("*.pack"))
    writer.save(mapper.state)
    after = sum(path.stat().st_size for path in tmp_path.glob("*.pack"))
    assert after - before < 0.01 * before


@pytest.mark.parametrize("kind", [SlamSystem, RefinedPoses])
def test_slam_goes_on_with_the_same_poses_corrections_and_covariances(kind, frames, tmp_path):
    config = SlamConfig()
    slam = kind(config)
    shown = frames if kind is RefinedPoses else [frame.at(None) for frame in frames]
    for frame in shown[:BEFORE]:
        slam.locate(frame)
        slam.corrections()
    saved = StateWriter(tmp_path, "poses", known_poses(config)).save(slam)
    again = load_state(tmp_path, saved, known_poses(SlamConfig()))
    assert len(again.keyframes) == len(slam.keyframes) > 1
    for frame in shown[BEFORE:]:
        np.testing.assert_equal(again.locate(frame), slam.locate(frame))
        np.testing.assert_equal(dict(again.corrections()), dict(slam.corrections()))
    slam.finish()
    again.finish()
    np.testing.assert_equal(again.trajectory(), slam.trajectory())
    np.testing.assert_equal(dict(again.map.graph.covariances()), dict(slam.map.graph.covariances()))


def test_poses_solved_beforehand_come_back_as_they_were(frames, tmp_path):
    system = SparseSystem()
    for frame in frames[::9]:
        system.locate(frame.at(None))
    system.finish()
    solved = SolvedPoses.of(system)
    solved.locate(frames[9])
    saved = StateWriter(tmp_path, "poses", known_poses(SlamConfig())).save((set(), {}, solved))
    _, _, again = load_state(tmp_path, saved, known_poses(SlamConfig()))
    assert len(again.poses) > 2
    np.testing.assert_equal(again.poses, solved.poses)
    np.testing.assert_equal(again.report().world_from_camera, solved.report().world_from_camera)
    solved.finish()
    again.finish()
    np.testing.assert_equal(dict(again.report().graph.covariances), dict(solved.report().graph.covariances))
