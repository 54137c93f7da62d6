"""Views of true instances: those that the recording's own instance images show, and nothing behind a wall."""

from __future__ import annotations

from collections import Counter

import numpy as np

from app.evaluation.evaluate_run import truth_scene
from app.evaluation.view_counts import MIN_IMAGE_SHARE, ViewCounter
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.frame import Intrinsics
from razer.metrics.scene_pair import TruthScene

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def squares(*depths):
    """Squares of 1 m across the optical axis, one behind the other, with ids from 1 on."""
    vertices = np.concatenate([SQUARE - (0.5, 0.5, -depth) for depth in depths])
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * i for i in range(len(depths))])
    instances = np.repeat(np.arange(1, len(depths) + 1), 4)
    return TruthScene(vertices, instances, instances, {i: str(i) for i in instances.tolist()}), triangles


def test_what_is_hidden_too_far_too_small_or_beside_the_image_is_not_shown():
    camera = Intrinsics(320, 240, 250, 250, 160, 120)
    truth, triangles = squares(2.0, 3.0)
    count = ViewCounter(truth, triangles, camera, (0.1, 4.0))
    here, turned, behind, back = (np.eye(4) for _ in range(4))
    turned[:3, :3] = np.diag([-1.0, 1, -1])
    behind[2, 3] = 2.5  # between both
    back[2, 3] = -2.5  # the nearer one is 4.5 m away
    assert count(np.stack([here])) == {1: 1}
    assert count(np.stack([here, behind, behind])) == {1: 1, 2: 2}
    assert count(np.stack([turned])) == count(np.stack([back])) == {}
    far = ViewCounter(truth, triangles, camera, (0.1, 100.0))
    distance = 250 / np.sqrt(MIN_IMAGE_SHARE * 320 * 240)  # at which a metre has the least number of pixels
    for factor, shown in ((0.8, {1: 1}), (1.3, {})):
        back[2, 3] = 2 - factor * distance
        assert far(np.stack([back])) == shown


def test_counts_are_those_of_the_instance_images():
    room = SyntheticRoom(0, 16, 160, 120)
    truth = room.truth(spacing_m=0.05)
    frames = [room[i] for i in range(len(room))]
    count = ViewCounter(truth_scene(truth), truth.triangles, room.intrinsics, (0.1, 5.0))
    found = count(np.stack([frame.world_from_camera for frame in frames]))
    expected: Counter[int] = Counter()
    for frame in frames:
        ids, pixels = np.unique(frame.instance_ids[(frame.depth > 0.1) & (frame.depth < 5)], return_counts=True)
        expected.update(int(i) for i, n in zip(ids, pixels, strict=True) if i and n >= MIN_IMAGE_SHARE * 160 * 120)
    ids = sorted({*found, *expected})
    difference = np.array([found.get(i, 0) - expected.get(i, 0) for i in ids])
    # The sensor has holes, and some lie on the edge of what counts.
    assert len(ids) > 20
    assert np.abs(difference).mean() < 0.7
    assert (np.abs(difference) <= 2).mean() > 0.9
