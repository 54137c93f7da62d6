"""Run folders made by somebody who means harm: nothing outside them is written or given out, nothing in them is obeyed
by a terminal or a browser."""

from __future__ import annotations

import json
import os
import re
import shutil
from http.client import HTTPConnection
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from app.console.streams import PlainConsole
from app.query.view_crops import CROPS, read_crop
from app.run_folder.folder_lock import FolderLock
from app.served_map.crop_pictures import CropPictures
from app.settings.run_config import InputSettings
from app.timeline.recording.saved_recording import SavedRecording
from app.timeline.viewer.free_port import free_port
from app.timeline.viewer.page_server import PageServer
from data_tools.predictions.submission import read_submission
from razer.errors import BadInput
from razer.saved_map import load_map
from razer.storage.atomic_files import replace_content
from tests.support.cli import razer

RUN = Path(__file__).resolve().parent.parent / "fixtures" / "run_format_1"
EVIL = "\x1b]0;x\x07[/red][link=file:///]<script>alert(1)</script></script>:chair:\u202e"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run that was handed over, with names that are not nice."""
    run = shutil.copytree(RUN, tmp_path / "run")
    content = json.loads((run / "instances.json").read_text())
    for instance in content["instances"]:
        instance["class"] = EVIL
    (run / "instances.json").write_text(json.dumps(content))
    return run


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    """A file of who opens the run, which is none of the run's business."""
    path = tmp_path / "secret"
    path.write_text("my own")
    return path


def test_a_lock_that_is_a_link_empties_no_file(run, secret, capsys):
    (run.parent / f".{run.name}.lock").symlink_to(secret)
    code, _, err = razer(capsys, "label", run, "--vocabulary", "coco")
    assert (code, len(err.splitlines())) == (2, 1)
    assert ".run.lock is a link, where the lock of the folder should be: remove it" in err
    assert secret.read_text() == "my own"


@pytest.mark.parametrize("make", [os.mkfifo, Path.mkdir])
def test_a_lock_that_is_no_file_is_not_waited_for(tmp_path, make):
    make(tmp_path / ".run.lock")
    if make is Path.mkdir:  # cannot be opened, so that there is no lock; what is written says so
        with FolderLock(tmp_path / "run"):
            pass
        return
    with pytest.raises(BadInput, match="is no file, where the lock"), FolderLock(tmp_path / "run"):
        pass


def test_a_hidden_part_that_is_a_link_is_not_written_through(tmp_path, secret):
    (tmp_path / f".part-{os.getpid()}-out.txt").symlink_to(secret)
    replace_content(tmp_path / "out.txt", "new")
    assert (tmp_path / "out.txt").read_text() == "new"
    assert secret.read_text() == "my own"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.txt", "secret"]


@pytest.mark.parametrize("what", ["file", "folder", "no picture"])
def test_no_crop_leads_to_a_file_elsewhere(run, secret, what):
    item = next(item for item in load_map(run).objects if item.views)
    name = f"{item.id:04d}-{item.views[0].frame:06d}.jpg"
    if what == "folder":
        (secret.parent / "elsewhere").mkdir()
        shutil.copy(secret, secret.parent / "elsewhere" / name)
        (run / CROPS).symlink_to(secret.parent / "elsewhere")
    else:
        (run / CROPS).mkdir()
        (run / CROPS / name).symlink_to(secret) if what == "file" else shutil.copy(secret, run / CROPS / name)
    pictures = CropPictures(run, InputSettings())
    if what == "no picture":
        with pytest.raises(BadInput, match="is no image"):
            pictures.picture(item, 0)
        with pytest.raises(BadInput, match="is no image"):
            read_crop(run / CROPS / name)
    else:
        assert pictures.count(item) == 0
        assert pictures.picture(item, 0) is None


@pytest.mark.parametrize("name", ["../secret", "/etc/passwd", "masks/../../secret"])
def test_masks_lie_in_the_folder_of_the_submission(tmp_path, name):
    (tmp_path / "scene.txt").write_text(f"{name} 3 0.5\n")
    with pytest.raises(BadInput, match=r"scene.txt, line 1: .* leads out of the folder"):
        read_submission(tmp_path / "scene.txt")


@pytest.mark.parametrize("verb", [("query", "chair"), ("query", EVIL), ("edit", "log"), ("query", "chair", "--json")])
def test_no_name_is_obeyed_by_a_terminal(run, capsys, verb):
    entry = {"number": 1, "epoch": 0, "time": EVIL, "author": EVIL, "map": "", "about": {}, "kind": "delete"}
    lines = [{"kind": "log", "format": 1}, entry | {"instance": 1}]
    if verb[1] == "log":
        (run / "edits.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    _, out, err = razer(capsys, verb[0], run, *verb[1:])
    assert out
    assert all(character.isprintable() or character == "\n" for character in out + err)


def test_a_console_says_texts_as_they_are(capsys):
    PlainConsole().print(EVIL, soft_wrap=True)
    said = EVIL.replace("\x1b", "\\x1b").replace("\x07", "\\x07").replace("\u202e", "\\u202e")
    assert capsys.readouterr().out == f"{said}\n"


def test_no_name_becomes_a_script_of_the_page(run, capsys, tmp_path):
    code, *_ = razer(capsys, "view", run, "--page", tmp_path / "map.html")
    page = (tmp_path / "map.html").read_text()
    assert code == 0
    assert "alert(1)" not in page  # names are in what is compressed
    assert len(re.findall(r"<script", page)) == page.count("</script>") == 3


def test_the_page_of_a_timeline_is_for_this_machine_alone(run):
    port = free_port(0)
    with PageServer(run, port) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        answers = {}
        for host in (f"127.0.0.1:{port}", f"localhost:{port}", "evil.example", f'x"</script><script>:{port}', ""):
            connection = HTTPConnection("127.0.0.1", port, timeout=10)
            connection.putrequest("GET", "/", skip_host=True)
            connection.putheader("Host", host)
            connection.endheaders()
            answers[host] = connection.getresponse().status
            connection.close()
        server.shutdown()
    assert [*answers.values()] == [200, 200, 421, 421, 421]


@pytest.mark.parametrize("content", [b"", b"RRF2", b"\x89PNG\r\n\x1a\n", b"x" * 5000])
def test_a_timeline_that_is_none_is_named(run, capsys, content, monkeypatch):
    (run / "timeline.rrd").write_bytes(content)
    with pytest.raises(BadInput, match=r"timeline.rrd is no timeline, or a damaged one"):
        SavedRecording(run / "timeline.rrd")
    monkeypatch.setenv("DISPLAY", ":0")
    code, _, err = razer(capsys, "view", run, run)
    assert (code, len(err.splitlines())) == (2, 1)
    assert "timeline.rrd is no timeline" in err


@pytest.mark.parametrize("code", [0x110000, 0xFFFFFFFF, 0xD800, 0xDFFF])
def test_texts_in_arrays_are_characters(tmp_path, code):
    from razer.files import read_npz

    names = np.array(["chair", "table"])
    names.view(np.uint32)[3] = code
    np.savez(tmp_path / "names.npz", names=names)
    with pytest.raises(BadInput, match=r"names.npz, member names.npy has texts with what is no character"):
        read_npz(tmp_path / "names.npz")
    big_endian = np.array(["chair", "\U0010ffff"], ">U5")
    np.savez(tmp_path / "whole.npz", names=big_endian, none=np.array([], "U3"), empty=np.array(["", ""]))
    assert read_npz(tmp_path / "whole.npz")["names"].tolist() == ["chair", "\U0010ffff"]
