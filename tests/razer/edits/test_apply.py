"""What edits make of a map, by invariants and by hand-made cases."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from razer.edits.session import EditSession
from razer.errors import BadInput
from tests.support.edited_maps import (
    CHAIR,
    FLOOR,
    LAMP,
    NOW,
    OTHER_CHAIR,
    TABLE,
    WALL,
    by_id,
    do,
    hand_made,
    plane,
    same_map,
    same_object,
    session_of,
    vertices_of,
)  # fmt: skip

EDITS = (
    ("rename", {"instance": LAMP, "name": "reading lamp"}),
    ("merge", {"instances": [CHAIR, OTHER_CHAIR]}),
    ("split", {"instance": TABLE, "region": plane(1, 0, 0, 0.5)}),
    ("move_border", {"source": WALL, "target": FLOOR, "region": plane(0, 0, -1, -0.42)}),
    ("relabel", {"instance": CHAIR, "class_name": "floor"}),
    ("delete", {"instance": LAMP}),
)


def edited(tmp_path, *edits):
    session = session_of(tmp_path)
    for kind, fields in edits:
        do(session, kind, **fields)
    return session


def test_undo_of_everything_is_the_same_map_to_the_byte_and_redo_the_edited_one(tmp_path):
    session = edited(tmp_path, *EDITS)
    after = session.panoptic
    assert not same_map(after, hand_made())
    for _ in EDITS:
        session.undo(time=NOW)
    assert same_map(session.panoptic, hand_made())
    assert session.epoch == 2 * len(EDITS)
    for _ in EDITS:
        session.redo(time=NOW)
    assert same_map(session.panoptic, after)


def test_a_session_opened_anew_has_the_map_that_the_first_left(tmp_path):
    first = edited(tmp_path, *EDITS)
    first.undo(time=NOW)
    assert same_map(session_of(tmp_path).panoptic, first.panoptic)


@pytest.mark.parametrize("order", list(permutations([OTHER_CHAIR, TABLE, LAMP])))
def test_a_merge_is_the_same_in_whatever_order_the_others_are_named(tmp_path, order):
    usual = edited(tmp_path / "usual", ("merge", {"instances": [CHAIR, OTHER_CHAIR, TABLE, LAMP]})).panoptic
    assert same_map(edited(tmp_path, ("merge", {"instances": [CHAIR, *order]})).panoptic, usual)


@pytest.fixture(autouse=True)
def folders(tmp_path):
    (tmp_path / "usual").mkdir()


def test_a_merge_pools_what_is_known_of_all(tmp_path):
    base = by_id(hand_made())
    panoptic = edited(tmp_path, ("merge", {"instances": [CHAIR, TABLE]})).panoptic
    merged = by_id(panoptic)[CHAIR]
    assert TABLE not in by_id(panoptic)
    assert vertices_of(panoptic, CHAIR) == vertices_of(hand_made(), CHAIR) | vertices_of(hand_made(), TABLE)
    assert merged.n_vertices == len(vertices_of(panoptic, CHAIR))
    assert merged.n_voxels == base[CHAIR].n_voxels + base[TABLE].n_voxels
    assert (merged.class_name, merged.is_edited, merged.is_named_by_hand) == ("chair", True, False)
    assert (merged.first_frame, merged.last_frame) == (10 - CHAIR, 50 + CHAIR)
    assert {vote.name for vote in merged.class_votes} == {"chair", "table"}
    assert [view.frame for view in merged.views] == [40, 20]
    # The table has more surface: its hypothesis is the strongest.
    np.testing.assert_array_equal(merged.embeddings, np.concatenate([base[TABLE].embeddings, base[CHAIR].embeddings]))
    sizes = np.array([base[TABLE].n_vertices, base[CHAIR].n_vertices])
    np.testing.assert_allclose(merged.weights, sizes / sizes.sum())
    points = panoptic.mesh.vertices[panoptic.mesh.instances == CHAIR].astype(float)
    assert merged.box.contains(points, margin_m=0.05).all()


@pytest.mark.parametrize("order", list(permutations([LAMP, TABLE, OTHER_CHAIR])))
def test_one_without_a_name_takes_that_of_the_largest(tmp_path, order):
    base = hand_made()
    nameless = tuple(replace(o, class_name=None) if o.id == CHAIR else o for o in base.objects)
    session = EditSession(tmp_path, replace(base, objects=nameless))
    do(session, "merge", instances=[CHAIR, *order])
    assert by_id(session.panoptic)[CHAIR].class_name == "table"


def test_votes_of_one_side_for_one_name_are_added_up(tmp_path):
    votes = by_id(edited(tmp_path, ("merge", {"instances": [CHAIR, OTHER_CHAIR]})).panoptic)[CHAIR].class_votes
    assert [(v.name, v.sector, v.frames, v.weight) for v in votes] == [("chair", s, 6, 3.0) for s in range(3)]
    assert [v.score for v in votes] == pytest.approx([0.8] * 3)


def test_split_and_merge_give_the_former_vertices_back(tmp_path):
    session = edited(tmp_path, ("split", {"instance": TABLE, "region": plane(1, 0, 0, 0.5)}))
    new = session.log.entries[-1].change.new
    assert new == 7
    one, other = vertices_of(session.panoptic, TABLE), vertices_of(session.panoptic, new)
    x_m = hand_made().mesh.vertices[:, 0]
    assert one
    assert other == {row for row in vertices_of(hand_made(), TABLE) if x_m[row] >= 0.5}
    objects = by_id(session.panoptic)
    assert objects[new].n_vertices == len(other)
    assert objects[new].n_voxels == 2 * len(other)
    assert objects[new].class_name == "table"
    assert objects[new].box.center[0] > 0.5 > objects[TABLE].box.center[0]
    do(session, "merge", instances=[TABLE, new])
    assert vertices_of(session.panoptic, TABLE) == vertices_of(hand_made(), TABLE)
    np.testing.assert_allclose(by_id(session.panoptic)[TABLE].box.extent, by_id(hand_made())[TABLE].box.extent)


def test_a_deleted_instance_leaves_its_surface_to_nobody(tmp_path):
    panoptic = edited(tmp_path, ("delete", {"instance": LAMP})).panoptic
    rows = sorted(vertices_of(hand_made(), LAMP))
    assert not panoptic.mesh.instances[rows].any()
    others = np.delete(np.arange(len(panoptic.mesh.instances)), rows)
    np.testing.assert_array_equal(panoptic.mesh.instances[others], hand_made().mesh.instances[others])
    assert LAMP not in by_id(panoptic)


def test_a_border_moves_vertices_and_both_boxes(tmp_path):
    panoptic = edited(tmp_path, ("move_border", EDITS[3][1])).panoptic
    z_m = hand_made().mesh.vertices[:, 2]
    moved = {row for row in vertices_of(hand_made(), WALL) if z_m[row] <= 0.42}
    assert moved
    assert vertices_of(panoptic, FLOOR) == vertices_of(hand_made(), FLOOR) | moved
    assert vertices_of(panoptic, WALL) == vertices_of(hand_made(), WALL) - moved
    assert by_id(panoptic)[WALL].box.center[2] > by_id(hand_made())[WALL].box.center[2] + 0.1
    assert by_id(panoptic)[FLOOR].n_vertices == len(vertices_of(panoptic, FLOOR))


def test_what_no_edit_names_stays_as_it_is(tmp_path):
    panoptic = edited(tmp_path, ("merge", {"instances": [CHAIR, OTHER_CHAIR]}), ("delete", {"instance": LAMP})).panoptic
    for number in (TABLE, FLOOR, WALL):
        assert same_object(by_id(panoptic)[number], by_id(hand_made())[number])


def test_a_class_decides_about_stuff_and_a_name_does_not(tmp_path):
    session = edited(tmp_path, ("relabel", {"instance": TABLE, "class_name": "brick wall"}))
    assert by_id(session.panoptic)[TABLE].is_stuff
    do(session, "relabel", instance=FLOOR, class_name="rug")
    assert not by_id(session.panoptic)[FLOOR].is_stuff
    do(session, "rename", instance=WALL, name="window")
    assert by_id(session.panoptic)[WALL].is_stuff


def test_parts_go_where_their_vertices_go(tmp_path):
    base = hand_made()
    x_m, labels = base.mesh.vertices[:, 0], np.zeros(len(base.mesh.instances), np.int32)
    rows = np.array(sorted(vertices_of(base, TABLE)))
    labels[rows[x_m[rows] >= 0.6]] = 8
    labels[rows[x_m[rows] < 0.3]] = 9
    parts = tuple(
        replace(by_id(base)[TABLE], id=i, part_of=TABLE, n_vertices=int((labels == i).sum()), class_name=None)
        for i in (8, 9)
    )
    base = replace(base, parts=parts, vertex_parts=labels)
    session = EditSession(tmp_path, base)
    do(session, "split", instance=TABLE, region=plane(1, 0, 0, 0.5))
    new = session.log.entries[-1].change.new
    assert new == 10  # parts have their ids, too
    assert {part.id: part.part_of for part in session.panoptic.parts} == {8: new, 9: TABLE}
    do(session, "delete", instance=new)
    assert {part.id: part.part_of for part in session.panoptic.parts} == {9: TABLE}
    assert set(np.unique(session.panoptic.vertex_parts)) == {0, 9}
    do(session, "merge", instances=[CHAIR, TABLE])
    assert {part.id: part.part_of for part in session.panoptic.parts} == {9: CHAIR}
    with pytest.raises(BadInput, match="9 is a part of instance 2"):
        do(session, "rename", instance=9, name="leg")


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        ("rename", {"instance": 99, "name": "x"}, "there is no instance 99"),
        ("merge", {"instances": [CHAIR, 99]}, "there is no instance 99"),
        ("split", {"instance": LAMP, "region": plane(1, 0, 0, 99)}, "nothing of lamp #4 lies in the region"),
        ("split", {"instance": LAMP, "region": plane(-1, 0, 0, -99)}, "nothing of lamp #4 lies outside the region"),
        ("move_border", {"source": LAMP, "target": CHAIR, "region": plane(0, 0, 1, 0.7)}, "do not touch"),
        ("move_border", {"source": LAMP, "target": LAMP, "region": plane(0, 0, 1, 0.7)}, "between two instances"),
    ],
)
def test_what_is_impossible_is_refused_and_leaves_no_trace(tmp_path, kind, fields, message):
    session = session_of(tmp_path)
    before = session.panoptic
    with pytest.raises(BadInput, match=message):
        do(session, kind, **fields)
    assert session.panoptic is before
    assert session.epoch == 0
    assert not (tmp_path / "edits.jsonl").exists()
