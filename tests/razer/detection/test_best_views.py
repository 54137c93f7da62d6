"""The frames that show an instance best."""

from __future__ import annotations

import json
from itertools import permutations

import numpy as np

from razer.config import BankSettings, LiftingSettings
from razer.detection.best_views import BestView, Region, best_views
from razer.detection.lifting import lift
from razer.detection.perception import Observation
from razer.frame import Masks
from razer.reintegration.frame_codec import pack, unpack
from razer.tracking.track import Track
from tests.support.scenes import axis_box, detection, frame_of, look, plane_depth, pose


def view(frame, pixels, whole=True):
    return BestView(frame, Region((0, 0, 10, 10), pixels, whole))


def frames(views):
    return [v.frame for v in views]


def test_the_largest_come_first_and_stand_apart():
    found = best_views([view(0, 100), view(5, 300), view(10, 200), view(40, 150), view(80, 120), view(120, 110)])
    assert frames(found) == [5, 40, 80]


def test_what_the_border_cuts_counts_half():
    assert frames(best_views([view(0, 150, whole=False), view(50, 100)])) == [50, 0]


def test_what_shows_next_to_nothing_is_left_out():
    assert frames(best_views([view(0, 1000), view(50, 100)])) == [0]


def test_the_order_of_equal_views_does_not_matter():
    views = [view(n, 100) for n in (0, 20, 40)]
    assert {tuple(frames(best_views(order))) for order in permutations(views)} == {(0, 20, 40)}


def test_a_region_covers_its_pixels():
    rows, columns = np.array([10, 12, 30]), np.array([20, 50, 21])
    region = Region.of(rows, columns, (60, 80), stride=2)
    assert region == Region((40, 20, 62, 42), 12, whole=True)
    assert not Region.of(rows, np.array([0, 5, 9]), (60, 80), stride=2).whole


def observed_square():
    frame = frame_of(plane_depth(pose(), (0, 0, 1), 2.0), pose(), index=7)
    masks = np.zeros((1, *frame.depth.shape), bool)
    masks[0, 40:80, 60:120] = True
    surface = look(frame)
    masks = Masks(masks, np.ones(1, np.float32))
    return Observation(frame, surface, lift(surface, masks, np.ones((1, 2), np.float32), LiftingSettings(), 0))


def test_a_detection_knows_its_region_also_after_it_was_kept():
    observation = observed_square()
    (found,) = observation.lifted.detections
    x, y, width, height = found.region.box
    assert (abs(x - 60) <= 4, abs(y - 40) <= 4, abs(width - 60) <= 8, abs(height - 40) <= 8) == (True,) * 4
    assert abs(found.region.pixels - 2400) < 500
    from tests.support.scenes import COARSE

    unpacked = unpack((pack(observation), pose()), COARSE)
    assert unpacked.lifted.detections[0].region == found.region


def test_a_track_keeps_its_best_views_and_takes_over_those_of_a_duplicate():
    box = axis_box((0, 0, 0), (1, 1, 1))

    def at(pixels):
        shown = detection(box)
        return type(shown)(**{**vars_of(shown), "region": Region((0, 0, 5, 5), pixels, True)})

    track, other = Track(1, at(100), 0, BankSettings()), Track(2, at(400), 100, BankSettings())
    track.observe(at(300), 30, 1.0)
    assert frames(track.views) == [30, 0]
    track.absorb(other)
    assert frames(track.views) == [100, 30, 0]


def vars_of(item):
    return {name: getattr(item, name) for name in item.__dataclass_fields__}


def test_views_are_plain_numbers():
    observation = observed_square()
    region = observation.lifted.detections[0].region
    assert json.loads(json.dumps([*region.box, region.pixels, region.whole]))
