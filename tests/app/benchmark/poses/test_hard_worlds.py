"""The hard worlds: each is as hard as it says, and shows pose estimation nothing but images."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.worlds.fast_turns import FASTEST_DEG_PER_S, VIDEO_PER_S, FastTurns
from app.benchmark.poses.worlds.hard_walk import HardWalk, JoinedFrames, dark
from app.benchmark.poses.worlds.hard_worlds import BLIND_S, IN_ORDER, KINECT, LONG_BLIND_S, STRIDES, WORLDS
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.frame import Frame, Intrinsics
from slam.se3 import angle_deg, length_m
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem

N_FRAMES = 24
SMALL_CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
SLOW = (  # to build
    *("look-alikes", "twin-rooms", "blind-between-twins", "sparse-look-alikes", "sparse-twin-rooms"),
    *IN_ORDER,
)


def walk_of(name: str, n_frames: int | None = N_FRAMES) -> HardWalk:
    return WORLDS[name].walk(1, n_frames)


def test_shots_are_numbered_and_timed_as_shown_and_bear_no_pose():
    room = SyntheticRoom(0, 6, 32, 24)
    walk = HardWalk(room, (4, None, 0), 5.0, dark(0.5, 0.0, 0))
    first, blind, last = walk
    assert [shot.frame.index for shot in (first, blind, last)] == [0, 1, 2]
    assert [shot.frame.stamp for shot in (first, blind, last)] == pytest.approx([0, 0.2, 0.4])
    for shot, index in ((first, 4), (last, 0)):
        assert np.array_equal(shot.world_from_camera, room[index].pose)
        assert np.array_equal(shot.frame.depth, room[index].depth)
        assert np.abs(shot.frame.rgb - 0.5 * room[index].rgb).max() <= 0.5
        assert shot.frame.world_from_camera is None
        assert shot.frame.instance_ids is None
    assert blind.world_from_camera is None
    assert not blind.frame.rgb.any()
    assert not blind.frame.depth.any()


def test_noise_of_the_dark_is_that_of_the_frame_and_as_strong_as_asked():
    grey = np.full((240, 320, 3), 200, np.uint8)
    frames = [Frame(n, 0.0, grey, np.zeros((240, 320), np.float32), SMALL_CAMERA) for n in (3, 4)]
    one, other = (dark(0.25, 5.0, 7)(frame).rgb.astype(float) for frame in frames)
    assert np.array_equal(one, dark(0.25, 5.0, 7)(frames[0]).rgb)
    assert not np.array_equal(one, other)
    assert one.mean() == pytest.approx(50, abs=0.1)
    assert one.std() == pytest.approx(5, abs=0.1)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.full) if n in SLOW else n for n in WORLDS])
def test_a_walk_is_no_longer_than_asked_and_moves_as_a_hand_does(name):
    walk = walk_of(name)
    shown = [index for index in walk.order if index is not None]
    assert 0 < len(shown) <= max(N_FRAMES, 2 * N_FRAMES if name.startswith("stride") else 0)
    order = sorted(shown) if WORLDS[name].is_sparse else walk.order
    steps = [(a, b) for a, b in pairwise(order) if a is not None and b is not None]
    poses = walk.recording.poses
    moved = [np.linalg.inv(poses[a]) @ poses[b] for a, b in steps]
    fastest = max(angle_deg(step) for step in moved) * walk.frames_per_s
    assert max(length_m(step) for step in moved) * walk.frames_per_s < 1.2
    assert fastest < (FASTEST_DEG_PER_S + 20 if name == "fast-turns" else 130)
    assert 0 < walk.recording.intrinsics.width <= 640


@pytest.mark.parametrize("name", ["sparse-room", "sparse-room-1s"])
def test_few_pictures_are_shown_in_no_order_and_all_at_once(name):
    walk, other = walk_of(name, None), WORLDS[name].walk(2, None)
    every = round(15 / walk.frames_per_s)
    assert walk.order != tuple(sorted(walk.order))
    assert sorted(walk.order) == list(range(0, len(walk.recording), every))
    assert walk.order[:5] != other.order[:5]
    assert WORLDS[name].is_sparse


@pytest.mark.full
@pytest.mark.parametrize("name", IN_ORDER)
def test_few_pictures_are_shown_in_the_order_of_taking_one_a_second(name):
    walk = walk_of(name, None)
    assert walk.order == tuple(range(0, len(walk.recording), 16))
    assert walk.frames_per_s == pytest.approx(15 / 16)
    assert WORLDS[name].is_sparse


def test_strides_show_the_same_way_at_rates_of_one_video():
    walks = [walk_of(f"stride-{stride}") for stride in STRIDES]
    ends = [len(walk) / walk.frames_per_s for walk in walks]
    assert ends == pytest.approx([ends[0]] * len(walks), abs=max(STRIDES) / VIDEO_PER_S)
    for walk, stride in zip(walks, STRIDES, strict=True):
        assert walk.order == tuple(range(0, 2 * N_FRAMES, stride))
        assert walk.frames_per_s * stride == VIDEO_PER_S


def test_the_camera_is_blind_for_as_long_as_is_said():
    for name, seconds, stretches in (("blind-1s", BLIND_S, 2), ("blind-10s", LONG_BLIND_S, 1)):
        walk = walk_of(name, 60)
        blind = np.array([index is None for index in walk.order])
        assert blind.sum() == pytest.approx(stretches * seconds * walk.frames_per_s)
        assert np.count_nonzero(np.diff(blind.astype(int)) == 1) == stretches
        assert not blind[0]
        assert not blind[-1]


def test_joined_frames_are_those_of_one_recording_and_then_of_the_other():
    first, second = SyntheticRoom(0, 4, 32, 24), SyntheticRoom(1, 3, 32, 24)
    joined = JoinedFrames(first, second)
    assert len(joined) == len(joined.poses) == 7
    assert joined.intrinsics == first.intrinsics
    for index, frame in ((3, first[3]), (4, second[0]), (6, second[2])):
        assert joined[index].index == index
        assert np.array_equal(joined[index].rgb, frame.rgb)
        assert np.array_equal(joined.poses[index], frame.pose)
    with pytest.raises(IndexError):
        joined[7]


def test_back_in_the_evening_the_same_is_seen_in_another_light():
    """Where a blind camera comes back to by day."""
    day, evening = (walk_of(name, 60) for name in ("blind-10s", "re-lit"))
    assert len(day) == len(evening)
    assert [index is None for index in day.order] == [index is None for index in evening.order]
    begin, back = 0, len(day) - 1
    for number, changes in ((begin, False), (back, True)):
        seen = [walk.recording[walk.order[number]] for walk in (day, evening)]
        poses = [walk.recording.poses[walk.order[number]] for walk in (day, evening)]
        assert np.array_equal(*poses)
        assert np.array_equal(seen[0].depth, seen[1].depth)
        differs = np.abs(seen[0].rgb.astype(float) - seen[1].rgb).mean()
        assert differs > 2 if changes else differs == 0


@pytest.mark.full
@pytest.mark.parametrize("seed", [1, 6])
def test_a_camera_that_comes_back_in_the_evening_is_found(seed):
    figures = follow(WORLDS["re-lit"].walk(seed, None), SlamSystem()).figures(15.0)
    assert figures["share_tracked"] > 0.98
    assert figures["frames_to_recover"] <= 10
    assert figures["false_ties"] == 0
    assert figures["ate_cm"] < 1


def test_the_camera_turns_ever_faster_up_to_200_degrees_a_second():
    turns = FastTurns(1, 240, 32, 24, KINECT)
    rates = [np.degrees(np.linalg.norm(turns.turning_rad_s(n / VIDEO_PER_S))) for n in range(240)]
    assert max(rates[:30]) < 60
    assert 0.85 * FASTEST_DEG_PER_S < max(rates[-60:]) < 1.1 * FASTEST_DEG_PER_S
    steps = Rotation.from_matrix(turns.poses[:-1, :3, :3]).inv() * Rotation.from_matrix(turns.poses[1:, :3, :3])
    measured = np.degrees(steps.magnitude()) * VIDEO_PER_S
    assert np.abs(measured - (np.array(rates[:-1]) + rates[1:]) / 2).max() < 0.1 * FASTEST_DEG_PER_S


@pytest.mark.full
def test_between_the_twins_nothing_is_seen_from_room_to_room():
    walk = walk_of("blind-between-twins", None)
    middle = walk.order.index(None), len(walk) - walk.order[::-1].index(None)
    before, after = walk.order[middle[0] - 1], walk.order[middle[1]]
    x = walk.recording.poses[[before, after], 0, 3]
    assert x[1] - x[0] > 4


@pytest.mark.full
def test_rooms_that_share_little_hang_together():
    """A picture each second of an apartment: by the strongest features alone 39 of 100 are located."""
    walk = WORLDS["sparse-apartment"].walk(1, None)
    figures = follow(walk, SparseSystem()).figures(walk.frames_per_s)
    assert figures["share_tracked"] > 0.85
    assert figures["false_ties"] == 0
    assert figures["ate_cm"] < 1.5
