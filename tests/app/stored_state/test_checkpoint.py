"""The manifest of a checkpoint is this one or the one before, and says when it is neither."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from app.stored_state.checkpoint import FILE, Checkpoint, read_checkpoint
from app.stored_state.saved_state import SavedState
from app.stored_state.written_log import WrittenLog
from razer.errors import BadInput

LOG = WrittenLog("5f0c", (("timeline.0.rrd", 10), ("timeline.0.1.rrd", 20)))
ONE = Checkpoint(40, 150, SavedState("map", 3, (1, 3)), SavedState("poses", 3, (0,)), "ab12", "scannet200", LOG)


def test_it_comes_back_as_it_was(tmp_path):
    assert read_checkpoint(tmp_path) is None
    ONE.write(tmp_path)
    assert read_checkpoint(tmp_path) == ONE
    other = replace(ONE, n_frames=60, vocabulary=None, timeline=None)
    other.write(tmp_path)
    assert read_checkpoint(tmp_path) == other


def test_what_older_checkpoints_alone_needed_goes_after_the_new_one_is_there(tmp_path):
    for name in (
        "map-1.pack",
        "map-2.pack",
        "map-3.pack",
        "map-2.json",
        "map-3.json",
        "poses-0.pack",
        "poses-3.json",
        "poses-4.pack",
        "poses-4.json",
    ):  # the next one, under way
        (tmp_path / name).touch()
    ONE.write(tmp_path)
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [
        FILE,
        "map-1.pack",
        "map-3.json",
        "map-3.pack",
        "poses-0.pack",
        "poses-3.json",
        "poses-4.json",
        "poses-4.pack",
    ]


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", "null", "\xff", '{"format": 1}', "[" * 100_000, '{"format": 3}', '{"format": 3, "map": {"a": 1}}'],
)
def test_what_is_none_is_bad_input(tmp_path, content):
    (tmp_path / FILE).write_text(content, encoding="latin-1")
    with pytest.raises(BadInput):
        read_checkpoint(tmp_path)


@pytest.mark.parametrize("part", ["../../etc/passwd", "/etc/passwd", "timeline.rrd/../x", "other.rrd", ".."])
def test_it_names_no_file_that_is_not_of_the_timeline(tmp_path, part):
    ONE.write(tmp_path)
    content = json.loads((tmp_path / FILE).read_text())
    content["timeline"]["sizes"][0][0] = part
    (tmp_path / FILE).write_text(json.dumps(content))
    with pytest.raises(BadInput, match="damaged"):
        read_checkpoint(tmp_path)
