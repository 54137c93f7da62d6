"""The tracker from outside: hand-made detections in a world of counted cells, and what becomes of the tracks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from razer.config import MapperConfig
from razer.tracking.step_result import Decision
from tests.support.cell_world import CellMask, CellWorld, rectangle

TABLE = CellMask(rectangle(0, 10, 0, 20), (1, 0, 0))
LAMP = CellMask(rectangle(2, 6, 2, 6), (0, 1, 0))
CHAIR = CellMask(rectangle(12, 18, 25, 35), (0, 0, 1))


def told(decisions: Sequence[Decision]) -> list[tuple[str, int]]:
    return [(d.outcome, d.track_id) for d in decisions]


def ids(world: CellWorld) -> list[int]:
    return sorted(world.tracker.tracks)


def log_odds(world: CellWorld) -> dict[int, float]:
    return {track_id: track.existence.log_odds for track_id, track in world.tracker.tracks.items()}


def test_first_all_is_born_then_matched() -> None:
    world = CellWorld()
    assert told(world.frame(TABLE, CHAIR)) == [("born", 1), ("born", 2)]
    assert told(world.frame(CHAIR, TABLE)) == [("matched", 2), ("matched", 1)]
    assert told(world.frame()) == []
    assert world.owned(1) == TABLE.cells
    assert world.owned(2) == CHAIR.cells


def test_hits_and_misses_by_hand() -> None:
    """Two detections of 0.9, then a frame that sees the table alone, then one that sees neither."""
    world = CellWorld()
    world.frame(TABLE, CHAIR)
    world.frame(TABLE, CHAIR)
    world.frame(TABLE)
    world.frame(in_view=[])
    table, chair = (world.tracker.tracks[i] for i in (1, 2))
    assert (table.hits, chair.hits) == (3, 2)
    # The first detection is the prior; the second a hit of 0.9 and a miss of 0.1.
    kept = 0.5 ** (1 / 100)
    assert (table.existence.hits, table.existence.misses) == pytest.approx((0.9 * kept + 0.9, 0.1 * kept + 0.1))
    assert (chair.existence.hits, chair.existence.misses) == pytest.approx((0.9 * kept, 0.1 * kept + 1))


def test_five_cells_in_view_are_no_miss_and_six_are() -> None:
    world = CellWorld()
    world.frame(TABLE)
    for n_cells, missed in ((5, 0.0), (6, 6 / 100)):  # 200 cells are what is usual
        world.frame(in_view=sorted(TABLE.cells)[:n_cells])
        assert world.tracker.tracks[1].existence.misses == pytest.approx(missed)


def test_a_part_left_over_joins_its_track() -> None:
    """The mask of the whole and one of a part of it that looks like it: both are of the one track."""
    world = CellWorld()
    corner = CellMask(rectangle(0, 10, 0, 4), (1, 0.1, 0))
    world.frame(TABLE)
    assert told(world.frame(TABLE, corner)) == [("matched", 1), ("joined", 1)]
    assert told(world.frame(corner, TABLE)) == [("joined", 1), ("matched", 1)]
    track = world.tracker.tracks[1]
    assert track.hits == 3  # a frame is one hit, however many pieces
    assert track.moments.count > 0


def test_a_part_that_looks_like_another_thing_is_born() -> None:
    world = CellWorld()
    world.frame(TABLE)
    assert told(world.frame(TABLE, LAMP)) == [("matched", 1), ("born", 2)]
    assert told(world.frame(TABLE, LAMP)) == [("matched", 1), ("matched", 2)]
    assert LAMP.cells <= world.owned(2) | world.owned(1)


def test_join_can_be_switched_off() -> None:
    config = MapperConfig.model_validate({"association": {"join": False}})
    world, corner = CellWorld(config), CellMask(rectangle(0, 10, 0, 4), (1, 0, 0))
    world.frame(TABLE)
    assert told(world.frame(TABLE, corner)) == [("matched", 1), ("born", 2)]


def test_rivals_frame_after_frame_part_a_track_that_was_two_things() -> None:
    """Two boxes that look alike were one mask at first; two masks lie on the track in each later frame."""
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (1, 0, 0))
    world = CellWorld()
    world.frame(TABLE)
    outcomes = [told(world.frame(left, right)) for _ in range(10)]
    assert outcomes[:6] == [[("matched", 1), ("joined", 1)]] * 6  # some frames of a torn mask are no proof
    born_at = next(i for i, pair in enumerate(outcomes) if pair[1][0] == "born")
    assert 6 <= born_at <= 7  # 1 - 0.9^7 > 0.5
    assert [pair[1] for pair in outcomes[born_at + 1 :]] == [("matched", 2)] * (9 - born_at)


def test_fragments_that_later_masks_cover_are_fused() -> None:
    """Left and right were two masks once; a mask of both follows, and the older one survives with all cells."""
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (1, 0, 0))
    world = CellWorld()
    world.frame(left, right)
    assert world.fuse() == []  # one view apart: -2, and alike: +2.2
    world.frame(TABLE)
    assert world.fuse() == [(2, 1)]
    assert ids(world) == [1]
    assert world.owned(1) == TABLE.cells
    assert world.fuse() == []
    assert told(world.frame(right)) == [("matched", 1)]


def test_neighbours_that_one_mask_joins_once_are_not_fused() -> None:
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (0, 1, 0))
    world = CellWorld()
    for _ in range(2):
        world.frame(left, right)
    world.frame(TABLE)
    assert world.fuse() == []  # -4 + 2, and unlike
    assert ids(world) == [1, 2]


@pytest.mark.parametrize(("fuse_log_odds", "fused"), [(-4.7, [(2, 1)]), (-4.5, [])])
def test_any_pair_is_fused_that_embeddings_bring_to_the_bound(
    fuse_log_odds: float, fused: list[tuple[int, int]]
) -> None:
    """Four views apart, one together, and alike: -8 + 2 + 1.4, however far below what masks alone ask."""
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (1, 0, 0))
    world = CellWorld(MapperConfig.model_validate({"maintenance": {"fuse_log_odds": fuse_log_odds}}))
    for _ in range(4):
        world.frame(left, right)
    world.frame(TABLE)
    assert world.fuse() == fused


def test_fuse_alike_takes_like_pairs_and_each_track_once() -> None:
    world = CellWorld()
    same, other = (1, 0, 0), (0, 1, 0)
    vectors = (same, same, same, other, same)
    world.frame(*[CellMask(rectangle(0, 6, 7 * i, 7 * i + 6), vector) for i, vector in enumerate(vectors)])
    assert world.tracker.fuse_alike([(1, 2), (2, 3), (3, 4), (3, 99), (3, 5)]) == [(2, 1), (5, 3)]
    assert ids(world) == [1, 3, 4]


def test_renamed_tracks_go_on_under_their_new_ids() -> None:
    """Their place in the R-tree, and what views said about them, go with them."""
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (1, 0, 0))
    world = CellWorld()
    world.frame(left, right)
    world.frame(TABLE)
    matched = world.tracker.tracks[1]
    world.tracker.rename({1: 41, 2: 17})
    assert list(world.tracker.tracks) == [17, 41]
    assert world.tracker.tracks[41] is matched
    assert matched.id == 41
    assert world.tracker.fuse_duplicates() == [(41, 17)]  # the pair's views were kept: (17, 41) is one thing
    assert list(world.tracker.tracks) == [17]


def test_new_ids_are_larger_than_any_before() -> None:
    world = CellWorld()
    world.frame(TABLE, CHAIR)
    world.frame(*[CellMask(rectangle(20, 24, 0, 4), (0, 1, 0), score=0.3)])
    for _ in range(9):
        world.frame(TABLE, CHAIR)
    assert world.prune() == [3]
    assert told(world.frame(CellMask(rectangle(20, 24, 0, 4), (0, 1, 0)))) == [("born", 4)]


# What exists.


def test_a_thing_seen_twice_at_a_stride_and_then_out_of_view_stays() -> None:
    """Frames 0 and 10 show it; a hundred frames elsewhere do not speak of it."""
    world = CellWorld()
    for index in (0, 10):
        world.frame(TABLE, index=index)
    before = log_odds(world)
    for index in range(20, 1020, 10):
        world.frame(CHAIR, in_view=CHAIR.cells, index=index)
        assert world.prune() == []
    assert log_odds(world)[1] == before[1] > 0
    assert world.drop_unconfirmed() == []


def test_a_late_frame_that_shows_a_track_is_a_hit() -> None:
    """Relocalised or replayed: its index is lower than the last one's."""
    late, in_time = CellWorld(), CellWorld()
    for world, indices in ((late, (50, 60, 7)), (in_time, (50, 60, 70))):
        for index in indices:
            decisions = world.frame(TABLE, index=index)
    assert told(decisions) == [("matched", 1)]
    track = late.tracker.tracks[1]
    assert (track.hits, track.existence.misses) == (3, pytest.approx(in_time.tracker.tracks[1].existence.misses))
    assert (track.first_frame, track.last_frame) == (7, 60)
    assert log_odds(late) == log_odds(in_time)


def random_walk(seed: int) -> list[tuple[CellMask, ...]]:
    """Frames of three things, each found in some and torn in others."""
    rng = np.random.default_rng(seed)
    left, right = CellMask(rectangle(0, 10, 0, 12), (1, 0, 0)), CellMask(rectangle(0, 10, 12, 20), (1, 0, 0))
    frames = []
    for _ in range(12):
        things = [(TABLE,), (left, right)][rng.integers(2)]
        things += (LAMP,) * (rng.random() < 0.6) + (CHAIR,) * (rng.random() < 0.4)
        blurred = [(*mask.embedding, *rng.normal(0, 0.2, 3)) for mask in things]
        scored = [float(rng.uniform(0.3, 1)) for _ in things]
        frames.append(tuple(replace(m, embedding=e, score=s) for m, e, s in zip(things, blurred, scored, strict=True)))
    return frames


@pytest.mark.parametrize("seed", range(3))
def test_the_numbers_of_the_frames_do_not_matter(seed: int) -> None:
    """One by one, at stride 10, from late to early, and all the same: what happens is the same."""
    histories = []
    for number in (lambda i: i, lambda i: 10 * i + 3, lambda i: 1000 - i, lambda i: 5):
        world, history = CellWorld(), []
        for i, masks in enumerate(random_walk(seed)):
            history.append((told(world.frame(*masks, index=number(i))), world.fuse(), world.prune()))
        histories.append((history, log_odds(world), world.drop_unconfirmed()))
    assert histories[1:] == histories[:1] * 3


@pytest.mark.parametrize("n_views", [10, 50, 500])
def test_a_refrigerator_detected_in_a_fifth_of_the_views_is_an_instance(n_views: int) -> None:
    world = CellWorld()
    for view in range(n_views):
        world.frame(*[replace(CHAIR, score=0.8)] * (view % 5 == 0))
        assert world.prune() == []
    assert world.tracker.tracks[1].confirmed
    assert world.drop_unconfirmed() == []


@pytest.mark.parametrize(("score", "views_until_gone"), [(0.3, 2), (0.5, 5), (0.8, 11)])
def test_a_phantom_of_one_view_is_pruned(score: float, views_until_gone: int) -> None:
    """The counts are those of the literal products in test_existence."""
    world = CellWorld()
    world.frame(TABLE, replace(CHAIR, score=score))
    gone = []
    for _ in range(60):
        world.frame(TABLE)
        gone.append(world.prune())
    assert gone == [[]] * (views_until_gone - 1) + [[2]] + [[]] * (60 - views_until_gone)
    assert world.owned(2) == frozenset()
    assert ids(world) == [1]


@pytest.mark.parametrize("hits", [3, 300])
def test_what_was_carried_away_is_gone_after_enough_misses(hits: int) -> None:
    world = CellWorld()
    for _ in range(hits):
        world.frame(CHAIR)
    misses = 0
    while misses < 999 and not world.prune():
        world.frame()
        misses += 1
    assert ids(world) == []
    assert 20 < misses < 999  # and not because a detector failed now and then


def test_one_low_reading_prunes_nothing() -> None:
    """Of its won share, or of the voxels it owns in the frame that also shows it."""
    world = CellWorld()
    for _ in range(3):
        world.frame(TABLE, CHAIR)
    track = world.tracker.tracks[2]
    track.won_share = 0.01
    assert world.prune() == []
    world.frame(TABLE, CHAIR)
    track.n_voxels = 0
    assert world.prune() == []  # it was detected just now
    assert world.prune() == [2]  # its surface is gone, and nothing showed it since


def test_of_what_owns_no_surface_nothing_is_left() -> None:
    world = CellWorld()
    for _ in range(3):
        world.frame(TABLE, CHAIR)
    world.erase(CHAIR.cells)
    assert world.tracker.tracks[2].confirmed
    assert world.drop_unconfirmed() == [2]
    assert ids(world) == [1]


def test_at_the_end_what_is_unlikely_is_no_instance() -> None:
    """Scores of 0.4 and 0.6, each of one view that none can confirm: more likely a phantom, and a thing."""
    world = CellWorld()
    world.frame(replace(TABLE, score=0.4), replace(CHAIR, score=0.6))
    assert world.prune() == []
    assert world.drop_unconfirmed() == [1]
    assert ids(world) == [2]


def test_confirmed_tracks_can_be_spared() -> None:
    """While poses are corrected the map lies beside them: surface that a frame does not confirm need not be gone."""
    world = CellWorld()
    for _ in range(3):
        world.frame(TABLE, CHAIR)
    world.frame(CellMask(rectangle(20, 24, 0, 4), (0, 1, 0), score=0.3))
    for _ in range(9):
        world.frame(TABLE)
    world.erase(CHAIR.cells)
    assert world.tracker.tracks[2].confirmed
    assert world.prune(spare_confirmed=True) == [3]
    assert world.prune() == [2]


def test_nothing_is_missed_while_the_map_lies_beside_the_poses() -> None:
    """A thing that a frame does not show where the map has it may stand where the map does not have it yet."""
    world = CellWorld()
    world.frame(TABLE, replace(CHAIR, score=0.3))
    before = log_odds(world)
    for _ in range(5):
        world.frame(TABLE, is_beside=True)
    assert log_odds(world)[2] == before[2]
    world.frame(TABLE)
    assert log_odds(world)[2] < before[2]


def test_embeddings_speak_against_a_fusion_for_each_view_of_both_and_for_it_once() -> None:
    world = CellWorld()
    alike = replace(LAMP, embedding=CHAIR.embedding)
    for masks in [(TABLE, CHAIR, alike)] * 3 + [(TABLE,)] * 4:
        world.frame(*masks)
    table, chair, twin = (world.tracker.tracks[i] for i in (1, 2, 3))
    assert (table.hits, chair.hits, twin.hits) == (7, 3, 3)
    unlike, same = (chair.bank.log_odds_same(other.bank) for other in (table, twin))
    assert unlike < -1
    assert same > 1
    assert world.tracker._semantic_log_odds(1, 2) == pytest.approx(3 * unlike)
    assert world.tracker._semantic_log_odds(2, 3) == pytest.approx(same)
