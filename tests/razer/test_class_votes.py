"""Class votes by viewing sector: what counts is from how many sides a name is said, and not in how many frames."""

from __future__ import annotations

import numpy as np
import pytest

from razer.class_votes import ClassVote, VoteCount, best_name, name_evidence, usual_score
from razer.detection.view_sector import view_sector


def counted(*frames: tuple[str, int] | tuple[str, int, float] | tuple[str, int, float, float]) -> VoteCount:
    """Votes of frames (name, sector, score, weight)."""
    count = VoteCount()
    for name, sector, *rest in frames:
        score, weight = (*rest, 0.8, 0.5)[:2] if len(rest) < 2 else rest
        count.add(name, sector, weight, score)
    return count


def test_five_sides_outweigh_fifty_frames_of_one():
    count = counted(*[("armchair", 3)] * 50, *[("couch", sector) for sector in range(4, 9)])
    assert best_name(count.votes()) == "couch"
    assert best_name(counted(*[("armchair", 3)] * 50, ("couch", 4)).votes()) == "armchair"


def test_a_sector_is_shared_by_what_is_said_in_it():
    """Worked out by hand: three frames are 2 * 3 / 4 views, of which the better seen two have more."""
    evidence = name_evidence(counted(("cup", 0, 0.7, 0.6), ("cup", 0, 0.7, 0.6), ("bowl", 0, 0.7, 0.3)).votes(), 0.7)
    assert evidence == pytest.approx({"cup": 1.5 * 1.2 / 1.5, "bowl": 1.5 * 0.3 / 1.5})


def test_a_lower_score_counts_less_than_an_equal_one():
    votes = counted(("poster", 0, 0.62), ("bulletin board", 1, 0.74)).votes()
    assert best_name(votes) == "bulletin board"
    evidence = name_evidence(votes, usual_score(votes))
    assert evidence["poster"] < 1 < evidence["bulletin board"]
    # What is usual for a segmenter is no evidence by itself.
    shifted = counted(("poster", 0, 0.32), ("bulletin board", 1, 0.44)).votes()
    assert name_evidence(shifted, usual_score(shifted)) == pytest.approx(evidence)


def test_more_frames_and_more_sides_are_more_evidence():
    one, two, sides = (
        name_evidence(counted(*frames).votes(), 0.8)["bed"]
        for frames in ([("bed", 0)], [("bed", 0)] * 2, [("bed", 0), ("bed", 1)])
    )
    assert pytest.approx(one) == 1
    assert one < two < sides
    assert name_evidence(counted(*[("bed", 0)] * 1000).votes(), 0.8)["bed"] < 2


def test_the_order_of_frames_and_of_duplicates_changes_nothing():
    rng = np.random.default_rng(0)
    names = ["chair", "stool", "couch"]
    frames = [(names[rng.integers(3)], int(rng.integers(12)), rng.random(), rng.random()) for _ in range(40)]
    forth, back = counted(*frames), counted(*reversed(frames))
    first, second = counted(*frames[:13]), counted(*frames[13:])
    second.absorb(first)
    for other in (back, second):
        assert [(v.name, v.sector, v.frames) for v in other.votes()] == [
            (v.name, v.sector, v.frames) for v in forth.votes()
        ]
        assert [v.weight for v in other.votes()] == pytest.approx([v.weight for v in forth.votes()])
        assert [v.score for v in other.votes()] == pytest.approx([v.score for v in forth.votes()])


def test_no_votes_are_no_name():
    assert best_name(()) is None
    assert usual_score(()) == 0
    assert best_name((ClassVote("b", 0, 1, 0.5, 0.5), ClassVote("a", 1, 1, 0.5, 0.5))) == "a"  # equals: by name


def test_sectors_are_twelve_directions_that_turn_with_nothing():
    """Each is met, they are about 60 degrees apart, and distance does not matter."""
    rng = np.random.default_rng(1)
    rays = rng.standard_normal((600, 3))
    center = np.array([1.0, -2.0, 0.5])
    sectors = [view_sector(center, center + ray) for ray in rays]
    assert sorted(set(sectors)) == list(range(12))
    assert sectors == [view_sector(center, center + 7 * ray) for ray in rays]
    units = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    same = np.equal.outer(sectors, sectors)
    angles_deg = np.degrees(np.arccos(np.clip(units @ units.T, -1, 1)))
    assert angles_deg[same].max() < 80  # across a face of the dodecahedron round a corner
    assert angles_deg[~same].max() > 150
