"""The sheet of a comparison: its sentence, its scale of colours, and a plan on which paths lie where they were."""

from __future__ import annotations

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from app.comparison.matched_instances import Matching
from app.comparison.sheet import _extent, _plan_camera, heat_colors, sheet, summary
from app.comparison.top_view import TopView
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.scene_pair import TimedPoses
from razer.panoptic_map import PanopticMap
from tests.support.surfaces import box, joined, plate


def run(name, mesh, shift=0.0):
    poses = np.tile(np.eye(4), (20, 1, 1))
    poses[:, 0, 3], poses[:, 1, 3] = np.linspace(0.5, 3.5, 20), 1.5 + shift
    return SimpleNamespace(name=name, panoptic=PanopticMap((), mesh), trajectory=TimedPoses(np.arange(20.0), poses, 20))


def comparison(mesh, a_to_b_m, ate_m=0.026, matched=3, missed=1, extra=0):
    nothing = (None,)
    return SimpleNamespace(
        a=run("one", mesh),
        b=run("two", mesh, shift=0.03),
        truth_trajectory=None,
        pose=None if ate_m is None else SimpleNamespace(ate_rmse_m=ate_m),
        surface=None if a_to_b_m is None else {},
        a_to_b_m=a_to_b_m,
        instances=Matching(matched * nothing, missed * nothing, extra * nothing),
    )


def room():
    return joined(box((0, 0, 0), (4, 3, 2.5), 1, outwards=False), plate((1, 1, 0.5), (1, 0, 0), (0, 1, 0), 2))


def test_the_sentence_sums_up_what_there_is():
    near = np.array([0.001, 0.02, 0.04, 0.2])
    assert summary(comparison(room(), near, extra=2)) == (
        "Paths 2.6 cm apart; 75% of A's surface within 5 cm of B's; 3 of 4 instances in both, 2 more in B."
    )
    assert "over 99% of" in summary(comparison(room(), np.r_[np.zeros(999), 0.2]))
    assert "100% of" in summary(comparison(room(), np.zeros(9)))
    assert summary(comparison(room(), near, 0.004)).startswith("Paths 4 mm apart")
    assert summary(comparison(room(), near, 1.234)).startswith("Paths 1.23 m apart")
    assert summary(comparison(room(), None, None)) == "3 of 4 instances in both."
    assert summary(comparison(room(), None, None, 0, 0)) == "Nothing to compare."


def test_colours_get_darker_with_the_distance_and_end_at_ten_centimetres():
    colors = heat_colors(np.array([0.0, 0.025, 0.05, 0.075, 0.1, 0.5, np.inf]))
    brightness = colors.mean(axis=1)
    assert (np.diff(brightness[:5]) < -10).all()
    np.testing.assert_array_equal(colors[5:], colors[[4, 4]])


@pytest.mark.parametrize("up", [(0, 0, 1.0), (0, -1.0, 0), (0.5, 0.5, 1.0)])
def test_the_plan_lies_under_the_paths(up):
    view = TopView.of(np.array(up))
    points = np.random.default_rng(0).uniform([-3, 0, 0], [2, 5, 4], (500, 3))
    camera = _plan_camera(view, points)
    left, right, bottom, top = _extent(view, camera)
    width, height = camera.size
    pixels, flat = camera.project(points), view.project(points)
    np.testing.assert_allclose(left + (right - left) * pixels[:, 0] / width, flat[:, 0], atol=1e-6)
    np.testing.assert_allclose(top + (bottom - top) * pixels[:, 1] / height, flat[:, 1], atol=1e-6)


def decoded(content):
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)


def reddish(picture):
    return int(((picture[..., 0] - picture[..., 2] > 90) & (picture[..., 1] < 110)).sum())


def test_where_maps_differ_is_hot():
    mesh = room()
    same = np.zeros(len(mesh.vertices))
    other = np.where(mesh.instances == 2, 0.08, 0.0)
    cold, hot = (decoded(sheet(comparison(mesh, distances))) for distances in (same, other))
    assert reddish(hot) > reddish(cold) + 2000


def test_empty_maps_have_a_sheet_of_their_paths():
    picture = decoded(sheet(comparison(LabelledMesh.empty(), None)))
    blue, orange = (31, 111, 180), (230, 120, 30)
    for color in (blue, orange):
        assert (np.abs(picture - color).max(axis=2) < 60).sum() > 300
