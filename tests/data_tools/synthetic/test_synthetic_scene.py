"""Synthetic scenes as recordings: a pure function of scene, seed and index."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from data_tools.synthetic.camera.color_errors import blur_px
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S, usual_frames, walk
from data_tools.synthetic.rendered_sequence import CAMERA
from data_tools.synthetic.synthetic_scene import SCENES, SyntheticScene
from razer.errors import BadInput
from razer.frame import Frame


def same(one: Frame, other: Frame) -> bool:
    pairs = ((one.rgb, other.rgb), (one.depth, other.depth), (one.instance_ids, other.instance_ids))
    return all(np.array_equal(a, b) for a, b in pairs) and np.array_equal(one.pose, other.pose)


SLOW = {
    name: pytest.param(name, marks=pytest.mark.full) for name in ("apartment", "warehouse", "corridors", "twin-rooms")
}  # to build


@pytest.mark.parametrize("name", [SLOW.get(name, name) for name in SCENES])
def test_frames_depend_on_scene_seed_and_index_alone(name: str) -> None:
    sensor = SensorModel.kinect()
    scene = SyntheticScene(name, 0, 9, 64, 48, sensor=sensor)
    late, early = scene[7], scene[1]
    assert same(scene[7], late)
    other = SyntheticScene(name, 3, 9, 64, 48, sensor=sensor)[1]
    assert not np.array_equal(early.rgb, other.rgb)
    assert not np.array_equal(early.pose, other.pose)
    assert len(scene) == 9
    assert early.instance_classes == scene.classes
    assert set(np.unique(early.instance_ids)) - {0} <= set(scene.classes)
    with pytest.raises(IndexError):
        scene[9]


@pytest.mark.parametrize("name", ["room", "corridor-loop", "tabletop"])
def test_a_scene_sent_to_another_process_is_made_anew_and_is_the_same(name: str) -> None:
    scene = SyntheticScene(name, 0, 9, 64, 48, sensor=SensorModel.kinect())
    again = pickle.loads(pickle.dumps(scene))
    assert (again.name, len(again), again.classes) == (scene.name, 9, scene.classes)
    late = again[7]
    assert same(again[1], scene[1])
    assert same(late, scene[7])


def test_few_frames_are_as_blurred_as_those_of_their_moments_among_all() -> None:
    stations = SCENES["room"](1).stations
    usual = usual_frames(stations)
    everywhere = walk(stations, usual, 1)
    for n_frames in (5, 9, 60):
        few, earlier = walk(stations, n_frames, 1), walk(stations, n_frames, 1, earlier_s=1 / FRAMES_PER_S)
        for index in range(1, n_frames):
            moment = round(index * (usual - 1) / (n_frames - 1))
            blur = blur_px(few, index, CAMERA, 0.2, earlier[index])
            assert np.abs(blur - blur_px(everywhere, moment, CAMERA, 0.2)).max() < 0.2
    # The last frame is of the same moment, however many there are.
    sensor = SensorModel(shutter=1.0)
    last, alike = (SyntheticScene("room", 1, n, 96, 72, sensor=sensor)[n - 1].rgb.astype(float) for n in (usual, 5))
    sharp = SyntheticScene("room", 1, 5, 96, 72)[4].rgb
    assert np.abs(last - alike).mean() < 0.05
    assert np.abs(last - sharp).mean() > 0.2


def test_stamps_are_those_of_a_hand_however_many_frames_there_are() -> None:
    usual = SyntheticScene("tabletop", 0, None, 8, 8)
    assert usual[15].stamp == pytest.approx(1)
    few = SyntheticScene("tabletop", 0, 5, 8, 8)
    duration = usual[len(usual) - 1].stamp
    assert few[4].stamp == pytest.approx(duration)
    np.testing.assert_allclose(few[4].pose, usual[len(usual) - 1].pose, atol=1e-9)
    assert len(SyntheticScene("tabletop", 0, 0, 8, 8)) == len(usual)


def test_blur_is_that_of_the_moving_hand_and_not_of_the_gap_between_frames() -> None:
    """A shutter open for a fifth of 1/15 s sees the same motion whatever the rate of frames."""
    blurred = [
        SyntheticScene("room", 0, n, 160, 120, sensor=SensorModel(shutter=0.2))[(n - 1) // 2].rgb for n in (481, 61)
    ]
    sharp = SyntheticScene("room", 0, 61, 160, 120)[30].rgb
    change = [np.abs(image.astype(float) - sharp).mean() for image in blurred]
    assert change[0] > 0
    assert change[1] == pytest.approx(change[0], rel=0.5)


@pytest.mark.parametrize(
    ("options", "words"), [(("attic",), "choose one of room"), (("room", -1), "negative"), (("room", 0, -3), "-3")]
)
def test_what_is_no_scene_is_refused(options: tuple, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        SyntheticScene(*options)


def test_walls_may_be_bare_or_textured_and_all_else_stays_as_it_is() -> None:
    painted, textured, bare = (
        SyntheticScene("room", 1, 40, 160, 120, light="even", walls=walls)[20]
        for walls in ("painted", "textured", "bare")
    )
    walls = np.isin(painted.instance_ids, [n for n, name in painted.instance_classes.items() if name == "wall"])
    assert walls.mean() > 0.05
    for other in (textured, bare):
        assert np.array_equal(other.depth, painted.depth)
        assert np.array_equal(other.rgb[~walls & ~ceiling(other)], painted.rgb[~walls & ~ceiling(other)])

    def contrast(frame: Frame) -> float:
        """How much grey levels differ from pixel to pixel within walls."""
        steps = np.abs(np.diff(frame.rgb.astype(float).mean(axis=2), axis=1))
        within = walls[:, 1:] & (frame.instance_ids[:, 1:] == frame.instance_ids[:, :-1])
        return float(steps[within].mean())

    assert contrast(bare) < 0.2 * contrast(painted)
    assert contrast(textured) > 2 * contrast(painted)


def ceiling(frame: Frame) -> np.ndarray:
    return np.isin(frame.instance_ids, [n for n, name in frame.instance_classes.items() if name == "ceiling"])
