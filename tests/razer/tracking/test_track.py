"""A track's life: what it counts, how its box grows, and how sure it is of itself."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import BankSettings
from razer.detection.lifting import Detection
from razer.tracking.track import Track
from tests.support.scenes import axis_box, detection, unit

CUBE = axis_box((0, 0, 0), (1, 1, 1))
BANK = BankSettings()


def track_of(*found: Detection, track_id: int = 1) -> Track:
    """Seen once a frame, from frame 10 on."""
    track = Track(track_id, found[0], 10, BANK)
    for i, each in enumerate(found[1:], start=11):
        track.observe(each, i)
    return track


def test_a_new_track_is_its_detection() -> None:
    found = detection(axis_box((1, 2, 3), (0.5, 0.2, 0.1)), unit(3, 4), quality=0.4, class_name="cup")
    track = track_of(found, track_id=5)
    assert (track.id, track.hits, track.misses, track.first_frame, track.last_frame) == (5, 1, 0, 10, 10)
    assert track.box is found.box
    assert not track.confirmed
    assert track.class_name == "cup"
    assert_allclose(track.bank.embeddings, [unit(3, 4)])
    assert track.bank.mass == pytest.approx(0.4)


def test_moments_are_those_of_all_observed_points() -> None:
    boxes = [CUBE, axis_box((0.4, 0, 0), (1, 1, 1)), axis_box((0, 2, 0), (0.5, 2, 0.3))]
    track = track_of(*[detection(b) for b in boxes])
    expected = PointMoments.of(np.concatenate([b.corners() for b in boxes]))
    assert track.moments.count == expected.count
    assert_allclose(track.moments.mean, expected.mean)
    assert_allclose(track.moments.scatter, expected.scatter, atol=1e-12)


def test_the_box_grows_to_hold_every_observation() -> None:
    boxes = [CUBE, axis_box((1, 0, 0), (1, 1, 1)), axis_box((0, 0, 3), (0.2, 0.2, 4))]
    track = track_of(*[detection(b) for b in boxes])
    for box in boxes:
        assert track.box.contains(box.corners(), 1e-9).all()


def test_several_detections_of_one_frame_are_one_hit() -> None:
    track = track_of(detection(CUBE))
    track.observe(detection(CUBE), 11)
    track.observe(detection(CUBE), 11)
    assert track.hits == 2
    assert track.moments.count == 24
    assert track.last_frame == 11


def test_being_seen_ends_a_row_of_misses() -> None:
    track = track_of(detection(CUBE))
    track.misses = 7
    track.observe(detection(CUBE), 20)
    assert track.misses == 0
    assert track.last_frame == 20


def test_class_is_that_of_most_observations_and_ties_go_by_name() -> None:
    named = [detection(CUBE, class_name=name) for name in ("table", "chair", None, "chair", "table")]
    assert track_of(*named).class_name == "chair"
    assert track_of(*named, detection(CUBE, class_name="table")).class_name == "table"
    assert track_of(detection(CUBE)).class_name is None


def test_confidence_grows_with_hits_and_falls_with_missed_chances() -> None:
    values = []
    for hits in range(1, 12):
        track = track_of(*[detection(CUBE)] * hits)
        track.chances = hits
        values.append(track.confidence)
    assert (np.diff(values) > 0).all()
    assert values[1] == pytest.approx(0.5)  # two hits, each chance taken, one hypothesis
    assert 0.95 < values[-1] < 1
    track.chances = 44
    assert track.confidence == pytest.approx(values[-1] * 0.5)


def test_an_unsettled_bank_lowers_the_confidence() -> None:
    wavering = track_of(*[detection(CUBE, v) for v in [unit(1, 0), unit(1, 2)] * 4])
    settled = track_of(*[detection(CUBE, unit(1, 0))] * 8)
    assert settled.stability == pytest.approx(1.0)
    assert wavering.stability == pytest.approx(0.5)
    assert wavering.confidence == pytest.approx(settled.confidence * np.sqrt(0.5))


def test_refresh_forgets_what_the_voxels_no_longer_bear_out() -> None:
    track = track_of(detection(CUBE), detection(axis_box((9, 0, 0), (1, 1, 1))))
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.5, 0.5, (2000, 3)) * (1.0, 0.6, 0.2)
    track.refresh(points)
    assert track.n_voxels == track.moments.count == 2000
    assert_allclose(track.box.extent, [0.98, 0.6 * 0.98, 0.2 * 0.98], atol=0.03)
    assert_allclose(track.moments.mean, points.mean(axis=0))


def test_one_stray_voxel_does_not_stretch_the_refreshed_box() -> None:
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (2000, 3))
    points[0] = (30, 0, 0)
    track = track_of(detection(CUBE))
    track.refresh(points)
    assert track.box.extent.max() < 1.5


def test_too_few_voxels_leave_the_box_and_are_counted() -> None:
    track = track_of(detection(CUBE))
    track.refresh(np.zeros((3, 3)))
    assert track.n_voxels == 3
    assert track.box is CUBE


def test_absorbing_a_duplicate() -> None:
    older = track_of(*[detection(CUBE, class_name="chair")] * 3)
    newer = Track(2, detection(axis_box((1, 0, 0), (1, 1, 1)), class_name="sofa"), 4, BANK)
    for i in range(5, 30):
        newer.observe(detection(axis_box((1, 0, 0), (1, 1, 1)), class_name="sofa"), i)
    newer.confirmed, newer.n_voxels, older.n_voxels = True, 50, 30
    mass = older.bank.mass + newer.bank.mass
    older.absorb(newer)
    assert (older.id, older.first_frame, older.last_frame) == (1, 4, 29)
    assert older.confirmed
    assert older.hits == 26
    assert older.n_voxels == 80
    assert older.class_name == "sofa"
    assert older.bank.mass == pytest.approx(mass)
    assert older.moments.count == 8 * (3 + 26)
    for box in (CUBE, newer.box):
        assert isinstance(box, OrientedBox)
        assert older.box.contains(box.corners(), 1e-9).all()


def test_a_track_is_contested_when_rivals_last() -> None:
    track = track_of(detection(CUBE))
    for rivals, expected in ((5, False), (10, True)):
        for _ in range(rivals):
            track.note_rival(True)
        assert track.is_contested is expected
    for _ in range(20):
        track.note_rival(False)
    assert not track.is_contested
    for i in range(300):
        track.note_rival(i % 3 == 0)
        assert not track.is_contested
