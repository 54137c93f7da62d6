"""A track's life: what it counts, how its box grows, and how sure it is of itself."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import BankSettings
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.track import Track
from tests.support.scenes import axis_box, detection, unit

CUBE = axis_box((0, 0, 0), (1, 1, 1))
BANK = BankSettings()


def track_of(*found: Detection, track_id: int = 1) -> Track:
    """Seen once a frame, from frame 10 on, each frame a view of its own."""
    track = Track(track_id, found[0], 10, BANK)
    for i, each in enumerate(found[1:], start=11):
        track.observe(each, i, 1.0)
        track.count_hit(each.score, 1.0)
    return track


def test_a_new_track_is_its_detection() -> None:
    found = detection(axis_box((1, 2, 3), (0.5, 0.2, 0.1)), unit(3, 4), quality=0.4, class_name="cup")
    track = track_of(found, track_id=5)
    assert (track.id, track.hits, track.first_frame, track.last_frame) == (5, 1, 10, 10)
    assert track.box is found.box
    assert track.existence.log_odds == pytest.approx(np.log(4))  # a score of 1 is taken for 0.8, and counts once
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


def test_a_thing_in_several_pieces_is_observed_by_each_and_hit_once() -> None:
    track = track_of(detection(CUBE))
    track.observe(detection(CUBE), 11, 1.0)
    track.observe(detection(CUBE), 11, 1.0)
    track.count_hit(1.0, 1.0)
    assert track.hits == 2
    assert track.moments.count == 24
    assert track.last_frame == 11


def test_a_frame_from_before_does_not_set_the_clock_back() -> None:
    """Relocalised or replayed: it shows the track, earlier than the last that did."""
    track = track_of(detection(CUBE), detection(CUBE))
    track.observe(detection(CUBE), 3, 1.0)
    assert (track.first_frame, track.last_frame) == (3, 11)


def test_an_unsure_detection_is_in_part_a_miss() -> None:
    track = track_of(detection(CUBE))
    track.count_hit(0.7, 0.5)
    assert (track.existence.hits, track.existence.misses) == pytest.approx((0.35, 0.15))


@pytest.mark.parametrize(("visible", "missed"), [(10, 0.25), (20, 0.5), (40, 1.0), (200, 1.0)])
def test_what_is_hardly_in_view_is_hardly_missed(visible: int, missed: float) -> None:
    """Detections of it are of 80 cells; half of that in view is a full chance."""
    track = track_of(*[detection(CUBE, cells=range(80))] * 3)
    hits = track.existence.hits
    track.count_miss(visible, 1.0)
    assert track.existence.misses == pytest.approx(missed)
    assert track.existence.hits == pytest.approx(hits * 0.5 ** (missed / 100))


def test_confirmed_is_more_likely_than_not_and_may_be_lost_and_won() -> None:
    track = Track(1, detection(CUBE, cells=range(10), score=0.4), 0, BANK)
    assert not track.confirmed  # one view of 0.4
    track.count_hit(0.8, 1.0)
    assert track.confirmed  # and a second
    for _ in range(20):
        track.count_miss(10, 1.0)
    assert not track.confirmed
    for _ in range(5):
        track.count_hit(0.8, 1.0)
    assert track.confirmed


def test_ties_of_class_go_by_name() -> None:
    named = [detection(CUBE, class_name=name) for name in (None, "table", "chair", "chair", "table")]
    assert track_of(*named).class_name == "chair"
    assert track_of(*named, detection(CUBE, class_name="table")).class_name == "table"
    assert track_of(detection(CUBE)).class_name is None


def test_a_bed_stays_a_bed_however_torn_the_cake_masks_are() -> None:
    """50 whole views as a bed; 25 as a cake that fall to three pieces, each a small part seen badly."""
    bed = detection(CUBE, unit(1, 0), quality=0.6, class_name="bed")
    cake = detection(CUBE, unit(1, 0.1), quality=0.05, class_name="cake")
    mixed = [bed, bed, cake, cake, cake] * 25  # 50 against 75
    assert track_of(*mixed).class_name == track_of(*reversed(mixed)).class_name == "bed"
    good_cakes = [bed, bed, detection(CUBE, unit(1, 0.1), quality=0.9, class_name="cake")] * 25
    assert track_of(*good_cakes).class_name == "bed"  # 50 * 0.6 against 25 * 0.9
    assert track_of(*good_cakes, *good_cakes[2::3]).class_name == "cake"


def test_a_name_whose_vector_disagrees_counts_less() -> None:
    """The embedding speaks, too: two views as a chair, and three equally good ones that look like nothing before."""
    scale = SimilarityScale()
    track = Track(1, detection(CUBE, unit(1, 0, 0, 0), class_name="chair"), 0, BANK, scale)
    for name, place in [("chair", 0), ("desk", 1), ("desk", 2), ("desk", 3)]:
        track.observe(detection(CUBE, np.eye(4)[place], class_name=name), 1, 1.0)
    assert scale.log_odds(scale.units(0.0)) == pytest.approx(-np.log(9))  # so that each desk counts for a tenth
    assert track.class_name == "chair"


def test_confidence_is_existence_times_support() -> None:
    track = track_of(detection(CUBE, score=0.6))
    assert track.confidence == pytest.approx(0.6)
    track.won_share = 0.5
    assert track.confidence == pytest.approx(0.3)
    values = []
    for _ in range(4):
        track.count_hit(0.9, 1.0)
        values.append(track.confidence)
    assert (np.diff([0.3, *values]) > 0).all()
    assert 0.499 < values[-1] < 0.5
    for _ in range(60):
        track.count_miss(8, 1.0)
    assert track.confidence < 0.2


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
        newer.observe(detection(axis_box((1, 0, 0), (1, 1, 1)), class_name="sofa"), i, 1.0)
        newer.count_hit(1.0, 1.0)
    newer.n_voxels, older.n_voxels = 50, 30
    mass = older.bank.mass + newer.bank.mass
    older.absorb(newer)
    assert (older.id, older.first_frame, older.last_frame) == (1, 4, 29)
    assert older.confirmed
    assert older.hits == 26
    assert older.existence.hits == newer.existence.hits  # in the views that both were seen in, one thing was seen once
    assert older.n_voxels == 80
    assert older.class_name == "sofa"
    assert older.bank.mass == pytest.approx(mass)
    assert older.moments.count == 8 * (3 + 26)
    for box in (CUBE, newer.box):
        assert isinstance(box, OrientedBox)
        assert older.box.contains(box.corners(), 1e-9).all()


def test_of_two_duplicates_either_may_absorb_the_other() -> None:
    """Which one is older depends on the order of masks, what they become does not."""

    def pair() -> tuple[Track, Track]:
        small = track_of(*[detection(CUBE, cells=range(20))] * 3)
        large = track_of(*[detection(axis_box((1, 0, 0), (1, 1, 1)), cells=range(90))] * 5, track_id=2)
        small.count_miss(20, 1.0)
        for _ in range(9):
            large.note_rival(True, 1.0)
        return small, large

    results = []
    for survivor, gone in (pair(), pair()[::-1]):
        survivor.absorb(gone)
        was = survivor.existence.misses
        survivor.count_miss(10, 1.0)
        results.append((survivor.hits, survivor.is_contested, survivor.existence))
        assert survivor.existence.misses < was + 0.5  # 10 cells are little of what 90 were detected of
    assert results[0] == results[1]
    assert results[0][:2] == (5, True)


def test_a_track_is_contested_when_rivals_last() -> None:
    track = track_of(detection(CUBE))
    for rivals, expected in ((5, False), (10, True)):
        for _ in range(rivals):
            track.note_rival(True, 1.0)
        assert track.is_contested is expected
    for _ in range(20):
        track.note_rival(False, 1.0)
    assert not track.is_contested
    for i in range(300):
        track.note_rival(i % 3 == 0, 1.0)
        assert not track.is_contested


def test_rivals_and_sizes_count_by_views_not_by_frames() -> None:
    """A camera at rest sees the same error again and again."""
    resting, moving = track_of(detection(CUBE, cells=range(10))), track_of(detection(CUBE, cells=range(10)))
    for _ in range(10):
        resting.note_rival(True, 0.05)
        moving.note_rival(True, 1.0)
        resting.observe(detection(CUBE, cells=range(100)), 1, 0.0)
    assert (resting.is_contested, moving.is_contested) == (False, True)
    resting.count_miss(5, 1.0)
    assert resting.existence.misses == 1  # five of ten cells in view: as before, half of what is usually detected
