"""A run that was cut off goes on from its newest checkpoint, and ends as if nothing had happened."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import N_FRAMES, QUICK, RUN_FILES, contents, listing, razer, write_small_room

# A segmenter of the project's own that fails, or kills its process, at a frame, for as long as a file is there.
FAILING_SEGMENTER = """
import os, signal
from pathlib import Path
from razer.models.geometric.segmenter import GeometricSegmenter

class Failing(GeometricSegmenter):
    def __init__(self, fuse, at, how="raise"):
        super().__init__()
        self.fuse, self.at, self.how = Path(fuse), at, how

    def segment(self, frame):
        if frame.index == self.at and self.fuse.exists():
            if self.how == "raise":
                raise RuntimeError("a bug in a plug-in")
            os.kill(os.getpid(), signal.SIGKILL)
        return super().segment(frame)
"""
RESULTS = ("mesh.ply", "instances.json", "embeddings.npz", "map.npz", "trajectory.txt")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("recording"))


@pytest.fixture
def failing(tmp_path, monkeypatch):
    """Arguments of a run whose segmenter fails at frame 9 as long as the file `fuse` is there."""
    (tmp_path / "failing_segmenter.py").write_text(FAILING_SEGMENTER)
    (tmp_path / "fuse").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))

    def arguments(how="raise"):
        options = {"fuse": tmp_path / "fuse", "at": 9, "how": how}
        settings = [part for name, value in options.items() for part in ("--set", f"segmenter.options.{name}={value}")]
        return ["--segmenter", "failing_segmenter:Failing", "--embedder", "appearance", *settings, *QUICK]

    return arguments


def unfinished(out: Path) -> Path:
    (folder,) = out.parent.glob(f".{out.name}.partial-*")
    return folder


def assert_same_results(run: Path, reference: Path) -> None:
    for name in RESULTS:
        assert (run / name).read_bytes() == (reference / name).read_bytes(), name


def test_after_an_error_the_run_goes_on_from_its_checkpoint(recording, tmp_path, failing, capsys):
    out, reference, arguments = tmp_path / "run", tmp_path / "reference", failing()
    with pytest.raises(RuntimeError, match="a bug in a plug-in"):
        razer(capsys, "run", recording, "-o", out, "--checkpoint-every", 4, *arguments)
    assert "razer run --resume" in capsys.readouterr().err
    assert json.loads((unfinished(out) / "checkpoint" / "checkpoint.json").read_text())["n_frames"] == 8

    code, _, err = razer(capsys, "run", "--resume", out)
    assert (code, len(err.splitlines())) == (2, 1)
    assert "--trust-plugins" in err  # what a file names is no code of the user's choice

    (tmp_path / "fuse").unlink()
    code, out_text, err = razer(capsys, "run", "--resume", out, "--trust-plugins", "--json")
    assert code == 0, err
    assert f"resumed after 8 of {N_FRAMES} frames" in err
    result = json.loads(out_text.splitlines()[-1])
    assert (result["used"], result["asked"], result["timings"]["resumed_at"]) == (N_FRAMES, N_FRAMES, [8])
    assert set(listing(out)) == RUN_FILES
    assert not list(tmp_path.glob(".run*"))

    assert razer(capsys, "run", recording, "-o", reference, *arguments)[0] == 0
    assert_same_results(out, reference)
    assert razer(capsys, "run", "--resume", out)[0] == 2  # there is nothing left to do


def test_a_frame_that_kills_the_helper_is_skipped_and_named(recording, tmp_path, failing, capsys):
    code, out, err = razer(capsys, "run", recording, "-o", tmp_path / "run", *failing("kill"), "--json")
    assert code == 0, err
    result = json.loads(out.splitlines()[-1])
    assert result["used"] == N_FRAMES - 1
    (skipped,) = result["skipped"]
    assert skipped["frame"] == 9
    assert "the process that finds masks ended with it (killed" in skipped["reason"]


def cut_off(recording: Path, out: Path, failing, capsys) -> Path:
    with pytest.raises(RuntimeError, match="a bug"):
        razer(capsys, "run", recording, "-o", out, "--checkpoint-every", 4, "--no-timeline", *failing())
    capsys.readouterr()
    return unfinished(out)


def refused(capsys, *arguments) -> str:
    code, _, err = razer(capsys, "run", *arguments)
    assert code == 2, err
    assert len(err.splitlines()) == 1
    return err


def test_what_cannot_be_resumed_is_refused_in_one_line_and_left_as_it_is(recording, tmp_path, failing, capsys):
    moving = shutil.copytree(recording, tmp_path / "moving")
    out = tmp_path / "run"
    partial = cut_off(moving, out, failing, capsys)
    before = contents(partial)
    assert "nothing to resume" in refused(capsys, "--resume", tmp_path / "other")
    assert "leave FOLDER out" in refused(capsys, recording, "--resume", out)
    assert "leave them out" in refused(capsys, "--resume", out, "--stride", "2")
    assert "FOLDER needs a value" in refused(capsys)
    out.mkdir()
    (out / "instances.json").write_text("another run, made since")
    assert "is there already: move it away" in refused(capsys, "--resume", out, "--trust-plugins")
    assert contents(out) == {"instances.json": b"another run, made since"}
    shutil.rmtree(out)

    picture = next((moving / "color").iterdir())
    original = picture.read_bytes()
    picture.write_bytes(next(p for p in sorted((moving / "color").iterdir()) if p != picture).read_bytes())
    first = sorted((moving / "color").iterdir())[0]
    saved = first.read_bytes()
    first.write_bytes(sorted((moving / "color").iterdir())[-1].read_bytes())
    assert "has changed since the run was begun" in refused(capsys, "--resume", out, "--trust-plugins")
    first.write_bytes(saved)
    picture.write_bytes(original)
    shutil.rmtree(moving / "depth")
    refused(capsys, "--resume", out, "--trust-plugins")
    assert contents(partial) == before


def test_a_damaged_checkpoint_is_bad_input(recording, tmp_path, failing, capsys):
    whole = cut_off(recording, tmp_path / "run", failing, capsys)
    for harm in ("cut pack", "flipped byte", "strange class", "no tree", "other settings", "no config"):
        place = tmp_path / harm / whole.name
        shutil.copytree(whole, place)
        damage(place, harm)
        assert "Traceback" not in refused(capsys, "--resume", tmp_path / harm / "run", "--trust-plugins"), harm


def damage(partial: Path, harm: str) -> None:
    pack = max((partial / "checkpoint").glob("map-*.pack"))
    tree = max((partial / "checkpoint").glob("map-*.json"))
    data = bytearray(pack.read_bytes())
    match harm:
        case "cut pack":
            pack.write_bytes(data[: len(data) // 2])
        case "flipped byte":
            data[len(data) // 2] ^= 1
            pack.write_bytes(data)
        case "strange class":
            tree.write_text(tree.read_text().replace("razer.tracking.track.Track", "os.system"))
        case "no tree":
            tree.unlink()
        case "other settings":
            config = partial / "config.toml"
            config.write_text(config.read_text().replace("max_bad", "max_worse"))
        case "no config":
            (partial / "config.toml").unlink()


def start(recording: Path, out: Path, *arguments: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "app", "run", recording, "-o", out, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)


def wait_for_checkpoints(process: subprocess.Popen, out: Path, count: int) -> None:
    seen = set()
    while process.poll() is None and len(seen) < count:
        for path in out.parent.glob(f".{out.name}.partial-*/checkpoint/checkpoint.json"):
            seen.add(path.stat().st_mtime_ns)
        time.sleep(0.01)


@pytest.mark.full
@pytest.mark.parametrize("seed", [18, 19, 20])
@pytest.mark.parametrize("poses", ["given", "slam", "refine"])
def test_runs_killed_at_random_moments_end_as_if_nothing_had_happened(tmp_path, poses, seed):
    """Fifteen times each, after two checkpoints or more; the whole group of processes is killed, as by a power cut."""
    recording = write_small_room(tmp_path / "recording", n_frames=40)
    arguments = ("--poses", poses, "--segmenter", "geometric", "--embedder", "appearance", *QUICK)
    reference, out, moments = tmp_path / "reference", tmp_path / "run", np.random.default_rng(seed)
    assert start(recording, reference, *arguments).wait() == 0
    for _ in range(5):
        process = start(recording, out, *arguments, "--checkpoint-every", "5")
        wait_for_checkpoints(process, out, 2)
        time.sleep(moments.uniform(0, 3))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if not out.exists():
            resumed = subprocess.run(
                [sys.executable, "-m", "app", "run", "--resume", out], capture_output=True, text=True, check=False
            )
            assert resumed.returncode == 0, resumed.stderr
        assert_same_results(out, reference)
        assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".run")) in ([], [".run.lock"])
        shutil.rmtree(out)


@pytest.mark.full
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_run_that_is_told_to_end_saves_what_was_mapped(recording, tmp_path, number, code):
    arguments = ("--segmenter", "geometric", "--embedder", "appearance", *QUICK, "--checkpoint-every", "1")
    process = start(recording, tmp_path / "run", *arguments)
    wait_for_checkpoints(process, tmp_path / "run", 3)
    process.send_signal(number)
    out, _ = process.communicate()
    assert process.returncode == code, out
    timings = json.loads((tmp_path / "run" / "timings.json").read_text())
    assert timings["interrupted"]
    assert 0 < timings["account"]["used"] < N_FRAMES
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_second_run_to_the_same_place_is_refused_with_the_first_ones_process(recording, tmp_path, capsys):
    from app.run_folder.folder_lock import FolderLock

    with FolderLock(tmp_path / "run"):
        err = refused(capsys, recording, "-o", tmp_path / "run")
    assert f"written by process {os.getpid()}" in err
    assert listing(tmp_path) == []


@pytest.mark.full
@pytest.mark.parametrize("timeline", ["--timeline", "--no-timeline"])
def test_where_no_file_may_grow_the_run_ends_in_one_line_and_leaves_nothing(recording, tmp_path, timeline):
    command = [sys.executable, "-m", "app", "run", recording, "-o", tmp_path / "run", "--checkpoint-every", "4"]
    command += ["--segmenter", "geometric", "--embedder", "appearance", timeline, *QUICK]
    limit = 100_000  # bytes a file
    ended = subprocess.run(
        ["prlimit", f"--fsize={limit}", *command], capture_output=True, text=True, check=False, timeout=120
    )
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.count("a checkpoint could not be written (File too large)") == 1
    assert ended.stderr.splitlines()[-1].startswith(f"razer: {tmp_path / 'run'} could not be written (File too large)")
    assert "Traceback" not in ended.stderr
    assert listing(tmp_path) == []
