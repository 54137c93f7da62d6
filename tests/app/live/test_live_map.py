"""A map that grows: what is told of it, asked of it, and edited in it before it is finished."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from app.live.live_map import LiveMap
from app.live.snapshot import Snapshot
from app.page.packet import unpack
from app.served_map.asked_map import NoSuchInstance
from app.served_map.edit_models import MergeRequest, RenameRequest
from app.settings.config_file import read_config
from razer.errors import BadInput, EditConflict
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk
from razer.plugins import NO_TRUST
from tests.support.edited_maps import CHAIR, LAMP, NAMES, TABLE, hand_made
from tests.support.served_maps import saved_map

HERE = Chunk(0, 0, 0)
EMPTY = LabelledMesh(
    np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8), np.zeros(0, np.int32), np.zeros((0, 3), np.int32)
)


@pytest.fixture
def told():
    return []


@pytest.fixture
def live(tmp_path, told):
    folder = tmp_path / "unfinished"
    folder.mkdir()
    config = read_config(None, (), {"embedder.name": "oracle"})
    return LiveMap(folder, config, lambda event, data: told.append((event, data)))


def snapshot(frame: int = 0, without: int | None = None, **fields) -> Snapshot:
    whole = hand_made()
    objects = tuple(o for o in whole.objects if o.id != without)
    return Snapshot(frame, objects, {HERE: whole.mesh}, up=np.array([0.0, 0.0, 3.0]), **fields)


def test_before_the_first_snapshot_the_map_is_empty(live):
    assert live.current.instances == {}
    header, _ = unpack(live.page())
    assert (header["growing"], header["instances"]) == (True, [])
    assert unpack(live.changes(0))[0]["blocks"] == []


def test_each_instance_is_told_once(live, told):
    live.take(snapshot(3, without=LAMP))
    live.take(snapshot(5))
    maps = [data for event, data in told if event == "map"]
    assert [(data["frame"], data["revision"]) for data in maps] == [(3, 1), (5, 2)]
    born = [data["id"] for event, data in told if event == "instance"]
    assert sorted(born) == sorted(NAMES)
    assert born[-1] == LAMP


def test_questions_are_answered_from_the_last_snapshot(live):
    live.take(snapshot(without=LAMP))
    assert not live.current.ask("lamp", 5).found
    live.take(snapshot())
    assert [hit.id for hit in live.current.ask("lamp", 5).hits] == [LAMP]
    assert live.current.instances[LAMP].vertices > 0
    assert live.current.panoptic.up == pytest.approx([0, 0, 1])


def test_what_changed_is_sent_and_nothing_else(live):
    live.take(snapshot())
    live.take(replace(snapshot(), chunks={}))
    assert len(unpack(live.changes(0))[0]["blocks"]) == 1
    assert unpack(live.changes(1))[0]["blocks"] == []
    live.take(replace(snapshot(), chunks={HERE: EMPTY}))
    (block,) = unpack(live.changes(2))[0]["blocks"]
    assert (block["key"], block["triangles"]) == ([0, 0, 0], 0)


def test_an_edit_stays_with_its_instance_when_the_map_goes_on(live, told):
    live.take(snapshot())
    done = live.edit(RenameRequest(epoch=0, author="Ada", instance=CHAIR, name="throne"))
    assert (done.epoch, done.edit.author) == (1, "Ada")
    assert told[-1] == ("edit", {"epoch": 1, "kind": "rename", "author": "Ada"})
    live.take(snapshot(1))
    assert [hit.id for hit in live.current.ask("throne", 5).hits] == [CHAIR]
    with pytest.raises(EditConflict, match="throne"):
        live.edit(RenameRequest(epoch=0, author="Bob", instance=CHAIR, name="stool"))
    with pytest.raises(BadInput):
        live.edit(RenameRequest(epoch=1, instance=99, name="x"))
    live.undo()
    assert live.current.instances[CHAIR].name == "chair"
    assert [edit.kind for edit in live.edits.edits] == ["rename", "undo"]


def test_what_has_no_surface_yet_cannot_be_edited(live):
    whole = hand_made()
    seen = replace(whole.mesh, instances=np.where(whole.mesh.instances == CHAIR, 0, whole.mesh.instances))
    live.take(Snapshot(0, whole.objects, {HERE: seen}, up=np.array([0.0, 0.0, 3.0])))
    for edit in (
        RenameRequest(epoch=0, instance=CHAIR, name="throne"),
        MergeRequest(epoch=0, instances=[TABLE, CHAIR]),
    ):
        with pytest.raises(EditConflict, match=f"{CHAIR} has no surface in the map yet"):
            live.edit(edit)
    assert live.edits.edits == []
    live.take(snapshot(1))
    live.edit(RenameRequest(epoch=0, instance=CHAIR, name="throne"))
    assert (live.current.instances[CHAIR].name, live.edits.problems) == ("throne", [])


def test_an_edit_that_finds_its_instance_no_more_is_told_of(live):
    live.take(snapshot())
    live.edit(RenameRequest(epoch=0, instance=LAMP, name="sun"))
    whole = hand_made()
    gone = replace(whole.mesh, instances=np.where(whole.mesh.instances == LAMP, 0, whole.mesh.instances))
    live.take(Snapshot(1, tuple(o for o in whole.objects if o.id != LAMP), {HERE: gone}, up=np.array([0, 0, 3.0])))
    (problem,) = live.edits.problems
    assert "edit 1 (rename)" in problem


def test_who_asks_while_the_folder_gets_its_name_waits_for_the_finished_map(live, tmp_path):
    live.take(snapshot())
    live.edit(RenameRequest(epoch=0, author="Ada", instance=CHAIR, name="throne"))
    live.take(snapshot(1))
    run = saved_map(tmp_path / "run")
    (tmp_path / "unfinished" / "edits.jsonl").rename(run / "edits.jsonl")
    (tmp_path / "unfinished").rmdir()
    threading.Timer(0.3, live.finish, (run, NO_TRUST)).start()
    assert [hit.id for hit in live.current.ask("throne", 5).hits] == [CHAIR]
    assert live.edits.epoch == 1


def test_the_finished_map_takes_its_place(live, told, tmp_path):
    live.take(snapshot(without=TABLE))
    live.finish(saved_map(tmp_path / "run"), NO_TRUST)
    assert told[-1] == ("edit", {"epoch": 0, "kind": "finished", "author": ""})
    assert set(live.current.instances) == set(NAMES)
    header, _ = unpack(live.page())
    assert not header.get("growing")
    with pytest.raises(NoSuchInstance):
        live.changes(0)
    live.edit(RenameRequest(epoch=0, instance=CHAIR, name="throne"))
    assert (tmp_path / "run" / "edits.jsonl").is_file()
