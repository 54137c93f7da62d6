"""What models that look at colour alone are shown, and where their masks end up on the grid of depth."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import pytest

from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.frame import Frame, Intrinsics, Masks
from razer.models.combined.segmenter import CombinedSegmenter
from razer.models.recorded_view import masks_of, vectors_of

DEPTH_CAMERA = Intrinsics(80, 60, 60.0, 60.0, 39.5, 29.5)
BASELINE_M = 0.05
FAR_M, NEAR_M = 2.0, 1.0
NEAR = (slice(20, 40), slice(30, 50))


@dataclass
class Thresholding:
    """Segments what is red, and describes masks by their mean colour; notes what it was shown."""

    looks_at_color_alone: ClassVar[bool] = True
    shown: list[Frame] = field(default_factory=list)
    masks: list[Masks] = field(default_factory=list)

    def segment(self, frame: Frame) -> Masks:
        self.shown.append(frame)
        red = frame.rgb[..., 0] > 150
        return Masks(np.stack([red, ~red, np.zeros_like(red)]), np.array([0.9, 0.8, 0.7], np.float32), ("a", "b", "c"))

    def embed(self, frame: Frame, masks: Masks) -> np.ndarray:
        self.shown.append(frame)
        self.masks.append(masks)
        return np.array([frame.rgb[mask].mean(axis=0) for mask in masks.masks], np.float32)


class OnDepthGrid(Thresholding):
    """The same, but it looks at depth, too."""

    looks_at_color_alone = False


def frame_beside(finer: int) -> tuple[Frame, np.ndarray]:
    """A near red square before a wall, with colour from a camera beside, and the picture as recorded."""
    camera = DEPTH_CAMERA.resized(80 * finer, 60 * finer)
    depth = np.full((60, 80), FAR_M, np.float32)
    depth[NEAR] = NEAR_M
    shift = round(60 * BASELINE_M / NEAR_M)
    rgb = np.full((60 * finer, 80 * finer, 3), 90, np.uint8)
    rgb[20 * finer : 40 * finer, (30 - shift) * finer : (50 - shift) * finer] = (255, 0, 0)
    color_from_depth = np.eye(4)
    color_from_depth[0, 3] = -BASELINE_M
    warp = ColorWarp.between(DEPTH_CAMERA, RgbdCalibration(camera, color_from_depth))
    bare = Frame(3, 0.1, np.zeros((60, 80, 3), np.uint8), depth, DEPTH_CAMERA)
    color = warp.apply(rgb, depth)
    return replace(bare, rgb=color.rgb, has_color=color.is_seen, recorded_color=color.recorded), rgb


@pytest.mark.parametrize("finer", [1, 2, 3])
def test_masks_of_the_recorded_picture_lie_on_the_depth_of_what_they_show(finer: int) -> None:
    frame, rgb = frame_beside(finer)
    model = Thresholding()
    masks = masks_of(model, frame)
    np.testing.assert_array_equal(model.shown[0].rgb, rgb)
    assert masks.class_names == ("a", "b"), "a mask of which nothing is left is none"
    np.testing.assert_allclose(masks.scores, [0.9, 0.8])
    assert frame.has_color is not None
    seen = masks.masks & frame.has_color
    square = np.zeros((60, 80), np.bool_)
    square[NEAR] = True
    assert (seen[0] != (square & frame.has_color)).sum() <= 20  # the borders, by a pixel
    assert not (seen[0] & seen[1]).any()


def test_a_model_that_looks_at_depth_is_shown_colour_on_its_grid() -> None:
    frame, _ = frame_beside(2)
    model = OnDepthGrid()
    masks_of(model, frame)
    assert model.shown[0] is frame


def test_parts_of_a_combination_are_shown_what_each_looks_at() -> None:
    frame, rgb = frame_beside(2)
    by_color, by_depth = Thresholding(), OnDepthGrid()
    masks = masks_of(CombinedSegmenter({"color": by_color, "depth": by_depth}), frame)
    assert by_color.shown[0].rgb.shape == rgb.shape
    assert by_depth.shown[0] is frame
    assert masks.masks.shape[1:] == (60, 80)


@pytest.mark.parametrize("finer", [1, 2, 3])
def test_vectors_are_those_of_the_recorded_picture_under_the_masks(finer: int) -> None:
    frame, rgb = frame_beside(finer)
    square = np.zeros((1, 60, 80), np.bool_)
    square[0][NEAR] = True
    model = Thresholding()
    vectors = vectors_of(model, frame, Masks(square, np.ones(1, np.float32)))
    np.testing.assert_allclose(vectors[0], (255, 0, 0), atol=40)  # but for a pixel at the border
    assert model.masks[0].masks.shape[1:] == rgb.shape[:2]
    is_red = rgb[..., 0] > 150
    assert model.masks[0].masks[0][is_red].mean() > 0.9, "without gaps between the pixels of depth"


def test_without_another_picture_the_frame_itself_is_shown() -> None:
    frame = replace(frame_beside(1)[0], recorded_color=None)
    model = Thresholding()
    masks_of(model, frame)
    vectors_of(model, frame, Masks.none(60, 80))
    assert all(shown is frame for shown in model.shown)


def test_no_masks_stay_none() -> None:
    frame, _ = frame_beside(2)

    class Blind(Thresholding):
        def segment(self, frame: Frame) -> Masks:
            return Masks.none(*frame.depth.shape)

    assert masks_of(Blind(), frame).masks.shape == (0, 60, 80)
    assert len(vectors_of(Blind(), frame, Masks.none(60, 80))) == 0
