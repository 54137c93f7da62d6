"""The door to the method: what a frame, a camera and masks refuse, and what they derive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics, Masks
from tests.support.scenes import frame_of, pose

CAMERA = Intrinsics(8, 6, 50.0, 40.0, 3.5, 2.5)


def good() -> Frame:
    return frame_of(np.ones((6, 8)), camera=CAMERA)


@pytest.mark.parametrize(
    "change", [{"width": 0}, {"height": -1}, {"fx": 0.0}, {"fy": -50.0}, {"fx": np.nan}, {"cx": np.inf}]
)
def test_impossible_cameras_are_refused(change: dict) -> None:
    with pytest.raises(BadInput):
        replace(CAMERA, **change)


def test_a_resized_camera_sees_the_same_rays() -> None:
    larger = CAMERA.resized(24, 30)
    # The corners of the image stay its corners, half a pixel outside the first and last pixels' centres.
    for camera in (CAMERA, larger):
        low = np.linalg.inv(camera.matrix) @ (-0.5, -0.5, 1)
        high = np.linalg.inv(camera.matrix) @ (camera.width - 0.5, camera.height - 0.5, 1)
        assert_allclose(low, [-4 / 50, -3 / 40, 1])
        assert_allclose(high, [4 / 50, 3 / 40, 1])
    assert larger.resized(8, 6) == CAMERA


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"rgb": np.zeros((6, 8, 4), np.uint8)}, "colour"),
        ({"rgb": np.zeros((6, 8, 3), np.float32)}, "colour"),
        ({"rgb": np.zeros((3, 4, 3), np.uint8)}, "colour"),
        ({"depth": np.zeros((6, 8), np.uint16)}, "depth"),
        ({"depth": np.zeros((8, 6), np.float32)}, "depth"),
        ({"instance_ids": np.zeros((3, 4), np.int32)}, "instance ids"),
        ({"part_ids": np.zeros((3, 4), np.uint8)}, "part ids"),
        ({"world_from_camera": np.full((4, 4), -np.inf)}, "pose"),
        ({"world_from_camera": np.diag([1.0, 1, 0, 1])}, "pose"),
        ({"world_from_camera": np.diag([1.0, 1, -1, 1])}, "pose"),
        ({"world_from_camera": np.eye(3)}, "pose"),
    ],
)
def test_broken_frames_are_unusable_and_say_what_is_wrong(change: dict, says: str) -> None:
    with pytest.raises(UnusableFrame, match=says) as error:
        replace(good(), **change)
    assert isinstance(error.value, BadInput)
    assert "\n" not in str(error.value)


def test_a_frame_without_a_pose_is_a_frame_but_has_no_pose() -> None:
    frame = replace(good(), world_from_camera=None)
    with pytest.raises(UnusableFrame, match="no pose"):
        _ = frame.pose
    placed = frame.at(pose((1, 2, 3)))
    assert_allclose(placed.pose[:3, 3], [1, 2, 3])
    assert placed.depth is frame.depth
    assert frame.world_from_camera is None


@pytest.mark.parametrize(
    ("masks", "scores", "names"),
    [
        (np.zeros((6, 8), bool), np.zeros(6, np.float32), None),
        (np.zeros((2, 6, 8), np.uint8), np.zeros(2, np.float32), None),
        (np.zeros((2, 6, 8), bool), np.zeros(3, np.float32), None),
        (np.zeros((2, 6, 8), bool), np.zeros(2, np.float32), ("one",)),
    ],
)
def test_masks_that_do_not_fit_together_are_refused(masks: np.ndarray, scores: np.ndarray, names: tuple) -> None:
    with pytest.raises(ValueError, match="masks"):
        Masks(masks, scores, names)


@pytest.mark.parametrize("dtype", [np.int32, np.uint16, np.int64])
def test_masks_from_ids_are_one_for_each_positive_id(dtype: type) -> None:
    ids: np.ndarray = np.array([[0, 7, 7], [3, 0, 900]], dtype)
    masks = Masks.from_ids(ids)
    assert len(masks) == 3
    assert np.array_equal(masks.masks, [ids == 3, ids == 7, ids == 900])
    assert_allclose(masks.scores, 1)
    assert len(Masks.from_ids(np.zeros((2, 3), dtype))) == 0


def test_negative_ids_are_nobody() -> None:
    assert np.array_equal(Masks.from_ids(np.array([[-1, 2]])).masks, [[[False, True]]])


def test_select_keeps_masks_scores_and_names_together() -> None:
    masks = Masks(np.eye(3, dtype=bool)[:, None], np.array([0.1, 0.2, 0.3], np.float32), ("a", "b", "c"))
    for keep in (np.array([True, False, True]), np.array([0, 2])):
        chosen = masks.select(keep)
        assert np.array_equal(chosen.masks, masks.masks[[0, 2]])
        assert chosen.class_names == ("a", "c")
        assert_allclose(chosen.scores, [0.1, 0.3])
    assert masks.select(np.array([2, 0])).class_names == ("c", "a")
    assert Masks.none(4, 5).masks.shape == (0, 4, 5)


def test_select_keeps_what_is_stuff_and_unknown_is_a_thing() -> None:
    pixels, scores = np.eye(3, dtype=bool)[:, None], np.ones(3, np.float32)
    masks = Masks(pixels, scores, stuff=np.array([True, False, True]))
    assert masks.select(np.array([2, 1])).is_stuff.tolist() == [True, False]
    assert Masks(pixels, scores).is_stuff.tolist() == [False] * 3
    for wrong in (np.array([True]), np.array([1, 0, 1])):
        with pytest.raises(ValueError, match="stuff"):
            Masks(pixels, scores, stuff=wrong)
