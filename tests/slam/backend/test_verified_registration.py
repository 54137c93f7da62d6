"""What is believed of a view in front of a keyframe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.verified_registration import VerifiedRegistration
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import no_features
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframes
from slam.se3 import angle_deg, exp_se3, length_m

NOMINAL = ColorCalibration.nominal()
KNOWN = IcpResult(np.eye(4), 1e6 * np.eye(6), 1e6 * np.eye(6), 1.0, 0.9, 0.9, 0.6, 100, NOMINAL)


class Creeping:
    """Registrations whose last steps are given, one after the other; how many were asked for is counted."""

    def __init__(self, *last_steps):
        self.results = [replace(KNOWN, last_step=step) for step in last_steps]
        self.n_asked = 0

    def register(self, *_):
        self.n_asked += 1
        return self.results[min(self.n_asked, len(self.results)) - 1]

    refine = register


def verified(view, *last_steps):
    keyframes = Keyframes()
    keyframe = keyframes.add(view, np.eye(4), 0, 0.0)
    registration = VerifiedRegistration(keyframes, SlamConfig())
    registration._registration = Creeping(*last_steps)
    return registration.register(keyframe, view, [np.eye(4)], NOMINAL), registration._registration.n_asked


@pytest.mark.parametrize(("last_steps", "n_asked"), [((0.1,), 1), ((3.0, 0.2), 2), ((4.0, 3.0, 2.0, 0.9), 4)])
def test_a_registration_is_gone_on_with_until_it_rests(views, last_steps, n_asked):
    result, asked = verified(views[10], *last_steps)
    assert result is not None
    assert result.last_step == last_steps[-1]
    assert asked == n_asked


def test_a_registration_that_never_rests_measured_nothing(views):
    result, asked = verified(views[10], 3.0)
    assert result is None
    assert asked < 10


def test_nothing_is_gone_on_with_that_is_not_believed_anyhow(views):
    keyframes = Keyframes()
    keyframe = keyframes.add(views[10], np.eye(4), 0, 0.0)
    registration = VerifiedRegistration(keyframes, SlamConfig())
    creeping = Creeping(3.0)
    creeping.results = [replace(creeping.results[0], agreement=0.2)]
    registration._registration = creeping
    assert registration.recognise(keyframe, views[10], [], NOMINAL) is None
    assert creeping.n_asked == 1


def rigid_motion(views, seen):
    keyframes = Keyframes()
    keyframe = keyframes.add(views[10], np.eye(4), 0, 0.0)
    return VerifiedRegistration(keyframes, SlamConfig()).rigid_motion(keyframe, seen)


def test_features_say_roughly_how_two_views_lie(room, views):
    found = rigid_motion(views, views[12])
    off = inverse(inverse(room[10].pose) @ room[12].pose) @ found.target_from_source
    assert found.n_explained >= 12
    assert length_m(off) < 0.1
    assert angle_deg(off) < 4


@pytest.mark.parametrize(
    "change",
    [
        {"depth": lambda sparse: sparse.depth / 2},  # where it stands, the other looked through
        {"rgb": lambda sparse: 255 - sparse.rgb},
    ],
    ids=["space", "colours"],
)
def test_features_say_nothing_where_space_or_colours_contradict_them(views, change):
    sparse = views[12].sparse
    changed = replace(views[12], sparse=replace(sparse, **{name: of(sparse) for name, of in change.items()}))
    assert rigid_motion(views, changed) is None


def test_pictures_without_the_usual_features_are_registered_by_wide_ones_from_where_they_are_known_to_be(room, views):
    """From a guess a few centimetres off, and with fewer features, as less chance matches them."""
    without = {n: replace(views[n], features=no_features(np.zeros((0, 32), np.uint8))) for n in (10, 12)}
    keyframes = Keyframes()
    keyframe = keyframes.add(without[10], np.eye(4), 0, 0.0)
    registration = VerifiedRegistration(keyframes, SlamConfig(), wide_alone=True)
    true = inverse(room[10].pose) @ room[12].pose
    guess = true @ exp_se3(np.array([0, 0.01, 0, 0.02, 0, 0]))
    result = registration.register(keyframe, without[12], [guess], NOMINAL)
    off = inverse(true) @ result.target_from_source
    assert result.n_features >= 8
    assert length_m(off) < 0.005
    assert angle_deg(off) < 0.2
    assert (
        registration.register(keyframe, without[12], [true @ exp_se3(np.array([0, 0.5, 0, 0.5, 0, 0]))], NOMINAL)
        is None
    )


@pytest.mark.parametrize(
    ("n_features", "wide_alone", "is_believed"), [(15, True, True), (14, True, False), (30, False, False)]
)
def test_fewer_wide_features_are_enough_where_views_hardly_overlap(views, n_features, wide_alone, is_believed):
    """A view of a bare wall has none of the usual features by chance: what is asked of it stays as it is."""
    view = replace(views[10], features=no_features(np.zeros((0, 32), np.uint8)))
    keyframes = Keyframes()
    keyframe = keyframes.add(view, np.eye(4), 0, 0.0)
    registration = VerifiedRegistration(keyframes, SlamConfig(), wide_alone)
    creeping = Creeping(0.1)
    creeping.results = [replace(KNOWN, overlap=0.1, n_features=n_features)]
    registration._registration = creeping
    assert (registration.recognise(keyframe, view, [], NOMINAL) is not None) == is_believed
    assert (registration.register(keyframe, view, [np.eye(4)], NOMINAL) is not None) == is_believed
