"""People in synthetic recordings: in the frames, out of the camera's way, and not in the truth."""

from __future__ import annotations

import pickle
from functools import cache

import numpy as np
import pytest

from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.walk import walk
from data_tools.synthetic.people.figure import Figure
from data_tools.synthetic.people.walkers import STRIDE_M, Walker, walkers
from data_tools.synthetic.scenes.corridors import corridors
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.errors import BadInput

N_FRAMES = 24


@cache
def scene(people: int) -> SyntheticScene:
    return SyntheticScene("corridors", 0, N_FRAMES, 64, 48, people=people)


@pytest.mark.full
def test_somebody_is_before_the_world_in_some_frames_and_has_no_id() -> None:
    changed = []
    for index in range(N_FRAMES):
        empty, peopled = scene(0)[index], scene(4)[index]
        nearer = peopled.depth < empty.depth - 1e-3
        changed.append(nearer.mean())
        assert empty.instance_ids is not None
        assert peopled.instance_ids is not None
        assert (peopled.instance_ids[nearer] == 0).all()
        np.testing.assert_array_equal(peopled.depth[~nearer], empty.depth[~nearer])
        np.testing.assert_array_equal(peopled.instance_ids[~nearer], empty.instance_ids[~nearer])
    assert max(changed) > 0.01


def test_people_are_not_in_the_truth_and_only_hide_what_is() -> None:
    empty, peopled = scene(0).truth(0.1), scene(4).truth(0.1)
    assert "person" not in peopled.instance_classes.values()
    np.testing.assert_array_equal(peopled.vertices, empty.vertices)
    np.testing.assert_array_equal(peopled.instances, empty.instances)
    assert not (peopled.visible & ~empty.visible).any()
    assert (empty.visible & ~peopled.visible).any()


def test_a_recording_with_people_is_made_again_in_another_process() -> None:
    again = pickle.loads(pickle.dumps(scene(4)))
    for index in (3, 17):
        np.testing.assert_array_equal(again[index].rgb, scene(4)[index].rgb)


def test_people_keep_away_from_the_camera_and_out_of_furniture() -> None:
    world = corridors(2)
    poses = walk(world.stations, 60, 2)
    found = walkers(world.things, poses, 3.0, 3, 2)
    assert len(found) == 3
    boxes = [t.bounds for t in world.things.values() if t.class_name in ("bench", "cabinet", "trash can", "chair")]
    assert boxes
    for walker in found:
        for index in range(60):
            place = walker.at(index / 3)[0][:2, 3]
            assert np.linalg.norm(place - poses[index, :2, 3]) > 0.85
            assert not any((low[:2] < place).all() and (place < high[:2]).all() for low, high in boxes)


def test_a_walker_goes_to_and_fro_facing_where_it_goes() -> None:
    figure = Figure.of(np.random.default_rng(0))
    walker = Walker(figure, np.array([(0.0, 0.0), (4.0, 0.0)]), 1.0)
    places = [walker.at(t)[0] for t in (0.0, 0.5, 4.5, 5.0)]
    np.testing.assert_allclose([p[:2, 3] for p in places[:2]], [(1.0, 0.0), (1.4, 0.0)], atol=1e-9)
    np.testing.assert_allclose([p[:2, 3] for p in places[2:]], [(3.4, 0.0), (3.0, 0.0)], atol=1e-9)
    np.testing.assert_allclose([p[:2, 1] for p in places], [(1, 0), (1, 0), (-1, 0), (-1, 0)], atol=1e-9)
    phases = [walker.at(t)[1] for t in (0.0, 0.5)]
    assert (phases[1] - phases[0]) % 1 == pytest.approx(0.4 / STRIDE_M)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.6])
def test_a_figure_stands_on_the_floor_as_tall_as_it_is(phase: float) -> None:
    figure = Figure.of(np.random.default_rng(5))
    low, high = figure.walking(phase).bounds
    assert low[2] == pytest.approx(0, abs=1e-9)
    assert high[2] == pytest.approx(figure.height_m, abs=0.12)
    assert (high - low)[0] < 0.8
    assert figure.walking(phase).class_name == "person"


def test_people_before_two_cameras_are_refused() -> None:
    with pytest.raises(BadInput, match="one camera"):
        SyntheticScene("room", 0, 4, 8, 8, people=1, misalignment=RgbdMisalignment(0.9))
