"""Edits stick to instances, not to numbers: in maps whose ids are others, that have grown, that lack something."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.edits.apply import apply_edits
from razer.edits.log import EditLog
from tests.support.edited_maps import (
    CHAIR,
    FLOOR,
    LAMP,
    OTHER_CHAIR,
    TABLE,
    WALL,
    by_id,
    do,
    hand_made,
    plane,
    same_map,
    session_of,
    vertices_of,
)  # fmt: skip

OTHER_IDS = {TABLE: 4, CHAIR: 6, OTHER_CHAIR: 1, LAMP: 7, FLOOR: 2, WALL: 3}  # 7 is what a split will have given


def renumbered(ids=OTHER_IDS, shift_m=0.0):
    """The hand-made map with other ids, and perhaps a little elsewhere."""
    base = hand_made()
    table = np.zeros(max(ids) + 1, np.int32)
    table[list(ids)] = list(ids.values())
    vertices = base.mesh.vertices + np.float32(shift_m)
    objects = sorted((replace(o, id=ids[o.id]) for o in base.objects), key=lambda o: o.id)
    return replace(
        base, objects=tuple(objects), mesh=replace(base.mesh, vertices=vertices, instances=table[base.mesh.instances])
    )


@pytest.fixture
def log(tmp_path):
    session = session_of(tmp_path)
    do(session, "rename", instance=LAMP, name="reading lamp")
    do(session, "split", instance=TABLE, region=plane(1, 0, 0, 0.5))
    do(session, "rename", instance=7, name="side table")
    do(session, "merge", instances=[CHAIR, OTHER_CHAIR])
    do(session, "delete", instance=WALL)
    return session.log


@pytest.mark.parametrize("shift_m", [0.0, 0.02])
def test_edits_find_their_instances_under_other_ids(log, shift_m):
    edited = apply_edits(renumbered(shift_m=shift_m), log)
    usual = apply_edits(hand_made(), log)
    assert edited.edit_problems == ()
    ids = OTHER_IDS | {7: 8}  # 7 is taken, by the lamp
    for own in (TABLE, CHAIR, LAMP, FLOOR, 7):
        assert vertices_of(edited, ids[own]) == vertices_of(usual, own)
        one, other = by_id(edited)[ids[own]], by_id(usual)[own]
        assert (one.class_name, one.is_edited, one.is_named_by_hand) == (
            other.class_name, other.is_edited, other.is_named_by_hand,
        )  # fmt: skip
    assert {o.id for o in edited.objects} == {ids[o.id] for o in usual.objects}


def test_pieces_that_are_one_by_now_need_no_merge(log):
    ids = OTHER_IDS | {OTHER_CHAIR: 6}
    base = renumbered(ids)
    base = replace(base, objects=tuple({o.id: o for o in base.objects}.values()))
    edited = apply_edits(base, log)
    assert edited.edit_problems == ()
    assert vertices_of(edited, 6) == vertices_of(hand_made(), CHAIR) | vertices_of(hand_made(), OTHER_CHAIR)


def test_what_is_not_there_any_more_is_said_and_the_rest_is_applied(log):
    base = renumbered()
    lamp = base.mesh.instances == OTHER_IDS[LAMP]
    base = replace(
        base,
        objects=tuple(o for o in base.objects if o.id != OTHER_IDS[LAMP]),
        mesh=replace(base.mesh, instances=np.where(lamp, 0, base.mesh.instances).astype(np.int32)),
    )
    edited = apply_edits(base, log)
    assert edited.edit_problems == ("edit 1 (rename) is not applied: lamp #4 is not found in this map any more",)
    assert {o.class_name for o in edited.objects} == {"table", "side table", "chair", "floor"}
    assert edited.epoch == 5


def test_a_neighbour_with_a_few_of_its_points_is_not_taken_for_it(log):
    base = renumbered()
    rows = np.flatnonzero(base.mesh.instances == OTHER_IDS[LAMP])
    labels = base.mesh.instances.copy()
    labels[rows] = 0
    labels[rows[: len(rows) // 3]] = OTHER_IDS[FLOOR]
    objects = tuple(o for o in base.objects if o.id != OTHER_IDS[LAMP])
    edited = apply_edits(replace(base, objects=objects, mesh=replace(base.mesh, instances=labels)), log)
    assert "lamp #4 is not found" in edited.edit_problems[0]
    assert by_id(edited)[OTHER_IDS[FLOOR]].class_name == "floor"


def test_a_session_goes_on_with_a_newer_map(tmp_path):
    session = session_of(tmp_path)
    do(session, "rename", instance=CHAIR, name="stool")
    session.rebase(renumbered())
    assert by_id(session.panoptic)[OTHER_IDS[CHAIR]].class_name == "stool"
    do(session, "rename", instance=OTHER_IDS[LAMP], name="reading lamp")
    # And back: each edit knows its own instance.
    panoptic = session_of(tmp_path).panoptic
    assert {i: o.class_name for i, o in by_id(panoptic).items() if o.is_named_by_hand} == {
        CHAIR: "stool", LAMP: "reading lamp",
    }  # fmt: skip


def test_without_edits_any_map_is_left_as_it_is():
    base = hand_made()
    assert same_map(apply_edits(base, EditLog()), base)
