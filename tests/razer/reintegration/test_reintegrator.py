"""The map follows corrected poses: as good as one fused at them from the start, with the instances it had."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import open3d as o3d
import pytest
import torch
from scipy.spatial.transform import Rotation

import razer.volume.blocks.block_pages
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.ground_truth import GroundTruth
from razer.config import MapperConfig
from razer.config.reintegration import ReintegrationSettings
from razer.frame import Frame
from razer.mapper import Mapper
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.instances.instance_ap import Scene, instance_ap
from razer.metrics.surface.nearest_vertices import transfer_labels
from razer.metrics.surface.surface_errors import metrics_of_distances
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.panoptic_map import PanopticMap
from razer.reintegration.id_matching import majority_ids, match_ids
from razer.reintegration.kept_frames import shifts_m
from razer.tracking.duplicates import find_duplicates, shared_votes
from razer.tracking.step_result import StepResult
from tests.support.scenes import COARSE, axis_box, box_depth, frame_of, plane_depth, pose

N_FRAMES, CLOSED = 80, 37  # two laps; the loop is closed as the camera comes back to where it began
DRIFT_M, DRIFT_DEG = 0.1, 3.0


@pytest.fixture(autouse=True, scope="module")
def small() -> Iterable[None]:
    """One thread, and room for what these maps need."""
    torch.set_num_threads(1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)
        yield


def mapper_with(settings: ReintegrationSettings, size_m: float = 0.04) -> Mapper:
    voxels = COARSE.model_copy(update={"voxel_size_m": size_m})
    return Mapper(MapperConfig(voxels=voxels, reintegration=settings), OracleSegmenter("none"), OracleEmbedder("none"))


def drifted(frame: Frame, share: float) -> Frame:
    drift = np.eye(4)
    drift[:3, :3] = Rotation.from_rotvec([0, 0, np.deg2rad(DRIFT_DEG * share)]).as_matrix()
    drift[:3, 3] = np.array([0.8, -0.4, 0.45]) * DRIFT_M * share
    return frame.at(drift @ frame.pose)


def run(frames: list[Frame], settings: ReintegrationSettings) -> tuple[Mapper, list[StepResult]]:
    """Map with poses that drift more and more, until all of them are corrected at once."""
    mapper = mapper_with(settings)
    steps = []
    for frame in frames:
        if frame.index == CLOSED:
            mapper.move({f.index: f.pose for f in frames[:CLOSED]})
        steps.append(mapper.step(drifted(frame, frame.index / CLOSED) if frame.index < CLOSED else frame))
    return mapper, steps


@pytest.fixture(scope="module")
def room() -> SyntheticRoom:
    return SyntheticRoom(seed=0, n_frames=N_FRAMES, width=160, height=120)


@pytest.fixture(scope="module")
def frames(room: SyntheticRoom) -> list[Frame]:
    return [room[i] for i in range(N_FRAMES)]


@pytest.fixture(scope="module")
def truth(room: SyntheticRoom) -> GroundTruth:
    return room.truth(spacing_m=0.08)


@pytest.fixture(scope="module")
def at_true_poses(frames: list[Frame]) -> Mapper:
    mapper = mapper_with(ReintegrationSettings())
    for frame in frames:
        mapper.step(frame)
    mapper.finish()
    return mapper


@pytest.fixture(scope="module")
def followed(frames: list[Frame]) -> tuple[Mapper, list[StepResult], set[int]]:
    mapper, steps = run(frames, ReintegrationSettings(enabled=True, replays_per_frame=1.0))
    ids = {t.id for t in mapper.tracks if t.confirmed}
    mapper.move({f.index: f.pose for f in frames})
    mapper.finish()
    return mapper, steps, ids


def distances(a: LabelledMesh, b: LabelledMesh) -> np.ndarray:
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor(b.vertices), o3d.core.Tensor(b.triangles.astype(np.uint32)))
    return scene.compute_distance(o3d.core.Tensor(a.vertices)).numpy()


def f_score(a: LabelledMesh, b: LabelledMesh) -> float:
    return metrics_of_distances(distances(a, b), distances(b, a)).fscore[0.02]


def ap50(panoptic: PanopticMap, truth: GroundTruth) -> float:
    ids = truth.instances[truth.visible]
    predicted = transfer_labels(panoptic.mesh.vertices, panoptic.mesh.instances, truth.vertices[truth.visible])
    return instance_ap(Scene(ids, predicted, {o.id: o.score for o in panoptic.objects})).ap50


def test_after_drift_and_correction_the_map_is_as_good_as_one_fused_at_the_true_poses(
    truth: GroundTruth, at_true_poses: Mapper, followed: tuple[Mapper, list[StepResult], set[int]]
) -> None:
    corrected, expected = followed[0].snapshot(), at_true_poses.snapshot()
    assert f_score(corrected.mesh, expected.mesh) > 0.99
    assert ap50(corrected, truth) >= ap50(expected, truth) - 0.02
    assert len(corrected.objects) <= len(expected.objects) + 1


def test_the_map_follows_while_the_run_goes_on_and_instances_keep_their_ids(
    followed: tuple[Mapper, list[StepResult], set[int]],
) -> None:
    mapper, steps, ids = followed
    rebuilt = [step for step in steps if step.rebuilt]
    assert [CLOSED <= step.frame_index < CLOSED + 15 for step in rebuilt] == [True]
    # What had been mapped twice was fused, and the older id stayed.
    assert all(gone > survivor for gone, survivor in rebuilt[0].fused)
    after = {o.id for o in mapper.snapshot().objects}
    assert len(ids & after) >= 0.9 * len(after)
    reintegrator = mapper.reintegrator
    assert reintegrator is not None
    assert reintegrator.n_rebuilds == 2
    assert reintegrator.n_replays <= 1.0 * N_FRAMES + reintegrator.n_kept


def test_kept_frames_alone_change_nothing_bit_for_bit(frames: list[Frame]) -> None:
    plain, keeping = mapper_with(ReintegrationSettings()), mapper_with(ReintegrationSettings(enabled=True))
    for frame in frames[:12]:
        one, other = plain.step(frame), keeping.step(frame)
        assert (one.id_image == other.id_image).all()
    # A correction of a millimetre is none: nothing is rebuilt, not even at the end.
    nudge = np.eye(4)
    nudge[0, 3] = 0.001
    keeping.move({frame.index: nudge @ frame.pose for frame in frames[:12]})
    assert list(keeping.catch_up()) == []
    plain.finish()
    keeping.finish()
    assert keeping.reintegrator is not None
    assert keeping.reintegrator.n_rebuilds == 0
    a, b = plain.snapshot(), keeping.snapshot()
    for name in ("vertices", "colors", "instances", "triangles"):
        assert (getattr(a.mesh, name) == getattr(b.mesh, name)).all()
    assert [(o.id, o.score) for o in a.objects] == [(o.id, o.score) for o in b.objects]


def test_corrections_without_kept_frames_are_refused(frames: list[Frame]) -> None:
    with pytest.raises(ValueError, match=r"reintegration\.enabled"):
        mapper_with(ReintegrationSettings()).move({0: np.eye(4)})


def wall_and_box(index: int, at: np.ndarray, box_at: float = 0.0) -> Frame:
    depth = np.minimum(plane_depth(at, (0, 0, 1), 2.0), box_depth(at, axis_box((box_at, 0, 1.6), (0.5, 0.5, 0.3))))
    frame = frame_of(depth, at, index=index)
    return Frame(
        index, frame.stamp, frame.rgb, frame.depth, frame.intrinsics, at, (frame.depth < 1.9).astype(np.int32) + 1
    )


def test_of_a_video_every_second_frame_is_kept_of_a_resting_camera_fewer_and_of_a_fast_one_all() -> None:
    kept = []
    for step_m in (0.03, 0.0, 0.2):
        mapper = mapper_with(ReintegrationSettings(enabled=True))
        for i in range(17):
            mapper.step(wall_and_box(i, pose((step_m * (i - 8), 0, 0))))
        assert mapper.reintegrator is not None
        kept.append(mapper.reintegrator.n_kept)
    assert kept == [9, 3, 17]


def test_where_all_frames_are_lost_after_all_nothing_of_them_is_left() -> None:
    mapper = mapper_with(ReintegrationSettings(enabled=True))
    for i in range(8):
        mapper.step(wall_and_box(i, pose((0.03 * i, 0, 0))))
    assert len(mapper.snapshot().mesh.vertices)
    mapper.move(dict.fromkeys(range(8)))
    panoptic = mapper.finish()
    assert not len(panoptic.mesh.vertices)
    assert panoptic.objects == ()
    # What comes late is mapped.
    for i in range(4):
        mapper.step(wall_and_box(20 + i, pose((0.03 * i, 0, 0))))
    assert len(mapper.finish().mesh.vertices)


def test_no_more_is_replayed_than_was_earned() -> None:
    settings = ReintegrationSettings(
        enabled=True, replays_per_frame=0.2, max_replays_per_frame=3, frames_per_keyframe=1, keyframe_stride=2
    )
    mapper = mapper_with(settings)
    for i in range(40):
        at = pose((0.05 * np.sin(i), 0, 0))
        mapper.step(wall_and_box(i, at))
        # Every frame, all that were seen before are said to lie somewhere else.
        mapper.move({j: pose((0.3 * (i % 2), 0, 0)) for j in range(i)})
        assert mapper.reintegrator is not None
        assert mapper.reintegrator.n_replays <= 0.2 * (i + 1) + settings.max_replays_per_frame
    shares = list(mapper.catch_up())
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) == mapper.reintegrator.n_kept
    assert list(mapper.catch_up()) == []


def test_a_thing_mapped_twice_shares_its_votes_and_things_seen_together_are_two() -> None:
    mapper = mapper_with(ReintegrationSettings(enabled=True))
    owners = []
    # 1 and 2 are one wall before and after a drift; 3, on the same voxels, is seen beside 1 all the time.
    mapper.voxels.admit(4)
    for i in range(12):
        at = pose((0.02 * i, 0, 0))
        frame = wall_and_box(i, at)
        surface = mapper.perception.observe(frame).surface
        mapper.voxels.integrate(frame, surface)
        mapper.voxels.vote(surface.cells, np.where(surface.cells.points[:, 2] > 1.9, 1 + i % 2, 4).astype(np.int32))
        mapper.voxels.vote(surface.cells, np.where(surface.cells.points[:, 2] > 1.9, 3, 0).astype(np.int32))
        owners.append(np.array([1, 3, 4] if i % 2 == 0 else [2, 4], np.int32))
    shared = shared_votes(mapper.voxels)
    assert shared[1, 2] > 0.8
    assert shared[1, 3] > 0.8
    assert shared.get((1, 4), 0) < 0.1
    duplicates = find_duplicates(mapper.voxels, owners, 0.3)
    assert (1, 2) in duplicates
    assert (1, 3) not in duplicates
    mapper.voxels.replace(2, 1)
    assert find_duplicates(mapper.voxels, owners, 0.3) == []


def test_the_shift_of_a_view_is_that_of_what_it_shows() -> None:
    at = pose((1, 2, 3), (10, 20, 30))
    moved = at.copy()
    moved[:3, 3] += (0.03, 0, 0.04)
    assert shifts_m(np.stack([at, at]), np.stack([at, moved])) == pytest.approx([0, 0.05])
    turned = at @ pose((0, 0, 0), (0, 0.5, 0))
    # Half a degree at a little more than two metres.
    assert shifts_m(at[None], turned[None])[0] == pytest.approx(np.deg2rad(0.5) * 2.2, rel=0.1)


def test_things_taken_for_one_while_the_map_lay_beside_the_poses_are_two_once_it_follows() -> None:
    apart_m = 3.0  # farther than a frame shows, as in either half of the run there is but one box
    mapper = mapper_with(ReintegrationSettings(enabled=True, frames_per_keyframe=1))
    steps = [0.02 * (i % 12 - 6) for i in range(24)]
    # From the twelfth frame on the camera is in front of a second box, and the estimate still before the first.
    for i, x_m in enumerate(steps):
        mapper.step(wall_and_box(i, pose((x_m, 0, 0))))
    before = {t.id for t in mapper.tracks if t.confirmed}
    assert len(before) == 2
    mapper.move({i: pose((x_m + apart_m, 0, 0)) for i, x_m in enumerate(steps) if i >= 12})
    mapper.finish()
    boxes = sorted((o for o in mapper.snapshot().objects if o.box.center[2] < 1.8), key=lambda o: o.box.center[0])
    assert [o.box.center[0] for o in boxes] == pytest.approx([0, apart_m], abs=0.08)
    # Half of the wall and one of the boxes are who they were.
    after = {o.id for o in mapper.snapshot().objects}
    assert before < after
    assert len(after) == 4
    # The map goes on with them.
    step = mapper.step(wall_and_box(24, pose((0, 0, 0))).at(pose((apart_m, 0, 0))))
    assert boxes[1].id in step.owners


def test_what_a_frame_showed_whose_pose_is_not_known_after_all_is_forgotten() -> None:
    shown = mapper_with(ReintegrationSettings(enabled=True, frames_per_keyframe=1))
    only = mapper_with(ReintegrationSettings(enabled=True, frames_per_keyframe=1))
    for i in range(12):
        frame = wall_and_box(i, pose((0.02 * i, 0, 0)))
        shown.step(wall_and_box(i, pose((5 + 0.02 * i, 0, 0))) if i < 5 else frame)
        if i >= 5:
            only.step(frame)
    shown.move(dict.fromkeys(range(5)))
    for mapper in (shown, only):
        mapper.finish()
    vertices, expected = (np.asarray(m.snapshot().mesh.vertices) for m in (shown, only))
    assert vertices[:, 0].max() < 3
    assert len(vertices) == pytest.approx(len(expected), rel=0.1)


def test_after_the_second_pass_old_ids_stand_for_who_took_over_most() -> None:
    before = np.array([1, 1, 1, 1, 1, 2, 2, 3, 4, 0], np.int32)
    after = np.array([8, 8, 8, 9, 9, 9, 9, 9, 0, 9], np.int32)
    # 9 got two detections of each of 1 and 2, but 8 is more of 1 than anybody.
    assert match_ids(before, after) == {8: 1, 9: 2}
    assert majority_ids(before, after) == {1: 8, 2: 9, 3: 9}
    assert match_ids(before[:0], after[:0]) == {}


def test_frames_that_count_less_are_mapped_once_more_at_the_end() -> None:
    """A wall, that half of the frames show 4 cm too far: it lies the nearer to the others the less these count."""
    settings = ReintegrationSettings(enabled=True, frames_per_keyframe=1)
    frames = [
        frame_of(plane_depth(pose(), np.array([0.0, 0, 1]), 1.5 + 0.04 * (n % 2)), pose((0.03 * n, 0, 0)), index=n)
        for n in range(8)
    ]
    far_m = {}
    for weights in ({}, {1: 0.25, 3: 0.25, 5: 0.25, 7: 0.25}):
        mapper = mapper_with(settings)
        for frame in frames:
            mapper.step(replace(frame, instance_ids=np.zeros(frame.depth.shape, np.int32)))
        mapper.weigh(weights)
        assert mapper.reintegrator is not None
        n_before = mapper.reintegrator.n_rebuilds
        far_m[len(weights)] = float(np.median(mapper.finish().mesh.vertices[:, 2])) - 1.5
        assert mapper.reintegrator.n_rebuilds - n_before == (1 if weights else 0)
    assert far_m[4] < 0.7 * far_m[0]
