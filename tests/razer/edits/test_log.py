"""The log: its file, its damages, undo and redo, and several editors."""

from __future__ import annotations

import json
import threading

import pytest

from razer.edits.log import EditLog
from razer.errors import BadInput, EditConflict
from tests.support.edited_maps import (
    CHAIR,
    FLOOR,
    LAMP,
    NOW,
    OTHER_CHAIR,
    TABLE,
    WALL,
    do,
    plane,
    session_of,
)  # fmt: skip


def test_the_file_is_a_header_and_an_entry_a_line(tmp_path):
    session = session_of(tmp_path)
    do(session, "rename", instance=CHAIR, name="office chair")
    session.undo(time=NOW)
    header, first, second = map(json.loads, (tmp_path / "edits.jsonl").read_text().splitlines())
    assert header == {"format": 1, "kind": "log"}
    assert {k: first[k] for k in ("number", "epoch", "time", "author", "kind", "instance", "name")} == {
        "number": 1, "epoch": 0, "time": NOW, "author": "ann", "kind": "rename", "instance": CHAIR,
        "name": "office chair",
    }  # fmt: skip
    assert first["about"][str(CHAIR)]["name"] == "chair"
    assert len(first["about"][str(CHAIR)]["points"]) == 24
    assert second == {"number": 2, "epoch": 1, "time": NOW, "author": "", "kind": "undo", "edit": 1}


def test_entries_as_they_are_shown_say_what_is_undone(tmp_path):
    session = session_of(tmp_path)
    do(session, "rename", instance=CHAIR, name="a")
    do(session, "rename", instance=CHAIR, name="b")
    session.undo(time=NOW)
    listed = session.log.listed()
    assert [(e["number"], e["kind"], e["undone"]) for e in listed] == [
        (1, "rename", False), (2, "rename", True), (3, "undo", False),
    ]  # fmt: skip
    assert all("about" not in e and "map" not in e for e in listed)


def test_undo_and_redo_go_through_the_edits_in_order(tmp_path):
    session = session_of(tmp_path)
    with pytest.raises(EditConflict, match="nothing to undo"):
        session.undo(time=NOW)
    for name in ("a", "b", "c"):
        do(session, "rename", instance=CHAIR, name=name)
    assert [session.undo(time=NOW).change.edit for _ in range(3)] == [3, 2, 1]
    assert [session.redo(time=NOW).change.edit for _ in range(2)] == [1, 2]
    do(session, "rename", instance=CHAIR, name="d")
    with pytest.raises(EditConflict, match="nothing to redo"):
        session.redo(time=NOW)  # a new edit ends what could be done again
    assert [entry.number for entry in session.log.in_force] == [1, 2, 9]


def test_a_line_that_was_never_ended_is_none_and_the_next_takes_its_place(tmp_path):
    session = session_of(tmp_path)
    do(session, "rename", instance=CHAIR, name="a")
    path = tmp_path / "edits.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"number": 2, "epo')
    again = session_of(tmp_path)
    assert again.epoch == 1
    do(again, "rename", instance=CHAIR, name="b")
    assert path.read_bytes().startswith(whole)
    assert [entry.number for entry in EditLog.read(tmp_path).entries] == [1, 2]


HEADER = b'{"format": 1, "kind": "log"}\n'
ENTRY = b'{"number": 1, "epoch": 0, "time": "", "author": "", "kind": '


@pytest.mark.parametrize(
    "damage",
    [
        b"no json\n",
        b'{"format": 2, "kind": "log"}\n',
        b"[]\n",
        b'{"format": 1, "kind": "log"}\n{"number": 2}\n',
        HEADER + ENTRY + b'"undo", "edit": 1}\n',
        HEADER + ENTRY + b'"paint"}\n',
        HEADER + ENTRY + b'"delete", "instance": 1, "about": {"1": {"name": 5, "points": []}}}\n',
        HEADER + ENTRY + b'"delete", "instance": 1, "about": []}\n',
        HEADER + ENTRY + b'"delete", "instance": 1, "about": {"1": {"name": "x", "points": [[1, 2, NaN]]}}}\n',
        HEADER + b"5\n",
        b"\xff\xfe\n",
        b"[" * 100_000 + b"\n",
    ],
)
def test_a_damaged_log_is_named_and_nothing_is_written_over_it(tmp_path, damage):
    session = session_of(tmp_path)
    (tmp_path / "edits.jsonl").write_bytes(damage)
    with pytest.raises(BadInput, match=r"edits\.jsonl is damaged") as refused:
        session_of(tmp_path)
    assert "\n" not in str(refused.value)
    with pytest.raises(BadInput, match=r"edits\.jsonl is damaged"):
        do(session, "rename", instance=CHAIR, name="a")
    assert (tmp_path / "edits.jsonl").read_bytes() == damage


STALE = [
    ("rename", {"instance": CHAIR, "name": "stool"}, "chair #2 was named stool by edit 1"),
    ("relabel", {"instance": CHAIR, "class_name": "rug"}, "chair #2 was named rug by edit 1"),
    ("merge", {"instances": [TABLE, CHAIR]}, "chair #2 was merged into #1 by edit 1"),
    ("merge", {"instances": [CHAIR, LAMP]}, "chair #2 took in #4 by edit 1"),
    ("delete", {"instance": CHAIR}, "chair #2 was deleted by edit 1"),
    ("split", {"instance": CHAIR, "region": plane(1, 0, 0, 0.9)}, "chair #2 was split, into itself and #7 by edit 1"),
    (
        "move_border",
        {"source": CHAIR, "target": TABLE, "region": plane(-1, 0, 0, -0.85)},
        "chair #2 gave surface to #1",
    ),
    ("move_border", {"source": TABLE, "target": CHAIR, "region": plane(1, 0, 0, 0.7)}, "chair #2 took surface of #1"),
]


@pytest.mark.parametrize(("kind", "fields", "reason"), STALE)
def test_an_edit_that_is_late_is_refused_with_the_reason(tmp_path, kind, fields, reason):
    first, second = session_of(tmp_path), session_of(tmp_path)
    do(first, kind, **fields)
    with pytest.raises(EditConflict, match=reason):
        do(second, "rename", epoch=0, instance=CHAIR, name="armchair")
    assert EditLog.read(tmp_path).epoch == 1
    assert second.epoch == 1  # it has seen why
    do(second, "rename", epoch=0, instance=OTHER_CHAIR, name="armchair")  # of which nobody changed anything
    assert first.refresh()
    assert not first.refresh()
    assert {o.id: o.class_name for o in first.panoptic.objects} == {o.id: o.class_name for o in second.panoptic.objects}


def test_what_an_undo_changed_is_late_too(tmp_path):
    first, second = session_of(tmp_path), session_of(tmp_path)
    do(first, "rename", instance=CHAIR, name="a")
    second.refresh()
    first.undo(time=NOW)
    with pytest.raises(EditConflict, match="edit 1 of chair #2 was undone by edit 2"):
        do(second, "rename", epoch=1, instance=CHAIR, name="b")
    with pytest.raises(EditConflict, match="edit 2 came since you looked"):
        second.redo(time=NOW, epoch=1)


def test_an_instance_that_is_gone_is_known_to_have_gone(tmp_path):
    session = session_of(tmp_path)
    do(session, "merge", instances=[CHAIR, OTHER_CHAIR])
    do(session, "delete", instance=LAMP)
    with pytest.raises(BadInput, match="chair #3 was merged into #2 by edit 1"):
        do(session, "rename", instance=OTHER_CHAIR, name="x")
    with pytest.raises(BadInput, match="lamp #4 was deleted by edit 2"):
        do(session, "rename", instance=LAMP, name="x")


@pytest.mark.parametrize("epoch", [-1, 1, 99])
def test_an_epoch_that_never_was_is_refused(tmp_path, epoch):
    with pytest.raises(BadInput, match=f"epoch {epoch} is none of this map"):
        do(session_of(tmp_path), "rename", epoch=epoch, instance=CHAIR, name="x")


def test_an_id_that_a_split_gave_is_given_once(tmp_path):
    session = session_of(tmp_path)
    ids = []
    for number in (FLOOR, WALL):
        do(session, "split", instance=number, region=plane(1, 0, 0, 1.0))
        ids.append(session.log.entries[-1].change.new)
        session.undo(time=NOW)
    assert ids == [7, 8]


def test_threads_that_edit_at_once_leave_one_log(tmp_path):
    numbers = [TABLE, CHAIR, OTHER_CHAIR, LAMP, FLOOR, WALL]
    shared = session_of(tmp_path)

    def rename(number):
        session = shared if number % 2 else session_of(tmp_path)
        for turn in range(5):
            do(session, "rename", instance=number, name=f"thing {number} {turn}")

    threads = [threading.Thread(target=rename, args=(number,)) for number in numbers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    log = EditLog.read(tmp_path)
    assert [entry.number for entry in log.entries] == list(range(1, 31))
    assert {o.class_name for o in session_of(tmp_path).panoptic.objects} == {f"thing {n} 4" for n in numbers}
