"""One writer of a folder or file at a time, whichever verb writes it, and what cannot be written is said at once."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.run_folder.folder_lock import FolderLock, writing
from razer.errors import BadInput
from tests.support.cli import razer, write_small_room


def held(target: Path) -> subprocess.Popen[str]:
    """Another process that is writing a target until its standard input ends."""
    code = (
        "import sys; from pathlib import Path; from app.run_folder.folder_lock import writing\n"
        "with writing(Path(sys.argv[1])):\n    print('held', flush=True)\n    sys.stdin.read()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(target)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_each_verb_refuses_a_place_that_another_process_writes(tmp_path, capsys):
    room, out = write_small_room(tmp_path / "room"), tmp_path / "made" / "for" / "out"
    process = held(out)
    try:
        for verb in (
            ("convert", room, out),
            ("synth", out, "--frames", "2"),
            ("track", room, "-o", out),
            ("label", out, "--vocabulary", "coco"),
            ("compare", room, room, "-o", out),
            ("run", room, "-o", out),
        ):
            code, _, err = razer(capsys, *verb)
            assert code == 2, verb
            assert f"out is being written by process {process.pid}" in err.splitlines()[-1], verb
    finally:
        process.communicate("")
    assert not (tmp_path / "made").exists()  # nothing was written, so nothing stays


def test_two_converts_to_one_place_do_not_destroy_each_other(tmp_path):
    room, out = write_small_room(tmp_path / "room", n_frames=60), tmp_path / "out"
    command = [sys.executable, "-m", "app", "convert", str(room), str(out), "--lossless"]
    first = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    hidden = tmp_path / ".out.unfinished"
    while first.poll() is None and not hidden.exists():
        time.sleep(0.01)
    second = subprocess.run(command, capture_output=True, text=True, check=False)
    _, err = first.communicate()
    assert (first.returncode, second.returncode) == (0, 2), err + second.stderr
    said = second.stderr.splitlines()[-1]
    assert f"is being written by process {first.pid}" in said or "exists" in said
    assert len(list((out / "color").iterdir())) == 60
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "room"]


def test_a_lock_goes_with_its_holder_and_parents_stay_where_something_is_in_them(tmp_path):
    target = tmp_path / "a" / "b"
    with writing(target):
        target.mkdir()
    with FolderLock(target):
        pass
    assert target.is_dir()
    with pytest.raises(RuntimeError), writing(tmp_path / "c" / "d"):
        raise RuntimeError
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize("place", ["x" * 250, "y" * 300 + "/out", "file/out"])
def test_what_cannot_be_written_is_said_before_the_work(tmp_path, place):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="cannot be written"), writing(tmp_path / place):
        pytest.fail("the work began")


def test_what_permissions_allow_and_the_file_system_refuses_is_said_before_the_work():
    with pytest.raises(BadInput, match=r"/proc/poses\.txt cannot be written"), writing(Path("/proc/poses.txt")):
        pytest.fail("the work began")


def test_what_is_no_regular_file_is_never_replaced(tmp_path):
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(os.devnull)
    for target in (pipe, link):
        with pytest.raises(BadInput, match="no regular file"), writing(target):
            pytest.fail("the work began")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "pipe"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_said_before_the_work(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(BadInput, match="read-only"), writing(tmp_path / "out"):
        pytest.fail("the work began")


@pytest.mark.parametrize("verb", ["convert", "track"])
def test_no_room_is_one_line_that_names_the_place_and_leaves_nothing(tmp_path, verb):
    room, out = write_small_room(tmp_path / "room"), tmp_path / "out"
    limit = "import resource as r; r.setrlimit(r.RLIMIT_FSIZE, (100, 100)); from app.__main__ import program; program()"
    where = {"convert": [str(out)], "track": ["-o", str(out), "--max-frames", "2"]}[verb]
    command = [sys.executable, "-c", limit, verb, str(room), *where]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert f"{out} could not be written (File too large)" in done.stderr.splitlines()[-1]
    assert [path.name for path in tmp_path.iterdir()] == ["room"]
