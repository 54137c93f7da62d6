"""The run folder appears whole or not at all, and never over something that is not a run."""

from __future__ import annotations

import os

import numpy as np
import pytest

from app.frames.frame_accounting import FrameAccounting
from app.run_folder.run_folder import INSTANCES, RunFolder
from data_tools.recordings.trajectories import tum_text
from razer.errors import BadInput
from razer.storage.atomic_files import replace_files


def contents(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def write(text):
    return lambda path: path.write_text(text)


def make_run(final, text="old", overwrite=False):
    with RunFolder(final, overwrite=overwrite) as folder:
        folder.write(INSTANCES, write(text))
        folder.commit()


def test_nothing_under_the_final_name_before_the_commit_and_all_of_it_after(tmp_path):
    final = tmp_path / "out"
    with RunFolder(final) as folder:
        folder.write(INSTANCES, write("{}"))
        assert not final.exists()
        folder.commit()
    assert contents(tmp_path) == ["out", f"out/{INSTANCES}"]
    assert (final / INSTANCES).read_text() == "{}"


def test_a_failed_run_leaves_no_trace_not_even_of_parents_it_made(tmp_path):
    def fail():
        with RunFolder(tmp_path / "a" / "b" / "out") as folder:
            folder.write(INSTANCES, write("{}"))
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert contents(tmp_path) == []


def test_a_file_under_its_name_is_complete_even_if_its_writer_dies_half_way(tmp_path):
    def half(path):
        path.write_text("half")
        raise OSError("disk full")

    with RunFolder(tmp_path / "out") as folder:
        folder.write("map.npz", write("whole"))
        with pytest.raises(OSError, match="disk full"):
            folder.write("map.npz", half)
        assert (folder.partial / "map.npz").read_text() == "whole"


def test_writers_get_a_name_with_the_same_ending(tmp_path):
    with RunFolder(tmp_path / "out") as folder:
        folder.write("map.npz", lambda path: np.savez(path, a=1))
        assert [path.name for path in folder.partial.iterdir()] == ["map.npz"]


def test_an_existing_folder_is_kept_without_overwrite(tmp_path):
    make_run(tmp_path / "out")
    with pytest.raises(BadInput, match="--overwrite"):
        RunFolder(tmp_path / "out")


def test_overwriting_replaces_only_at_the_commit(tmp_path):
    make_run(tmp_path / "out", "old")
    with RunFolder(tmp_path / "out", overwrite=True) as folder:
        folder.write(INSTANCES, write("new"))
        assert (tmp_path / "out" / INSTANCES).read_text() == "old"
        folder.commit()
    assert (tmp_path / "out" / INSTANCES).read_text() == "new"
    assert contents(tmp_path) == ["out", f"out/{INSTANCES}"]


def test_a_failed_overwrite_keeps_the_old_run(tmp_path):
    make_run(tmp_path / "out", "old")
    with pytest.raises(RuntimeError), RunFolder(tmp_path / "out", overwrite=True):
        raise RuntimeError
    assert contents(tmp_path) == ["out", f"out/{INSTANCES}"]


def test_two_runs_to_one_place_do_not_destroy_each_other(tmp_path):
    make_run(tmp_path / "first", "first")
    with RunFolder(tmp_path / "out") as late:
        late.write(INSTANCES, lambda path: path.write_text("late"))
        (tmp_path / "first").rename(tmp_path / "out")
        with pytest.raises(BadInput, match=r"exists.*the finished run is in .*out\.1"):
            late.commit()
    assert (tmp_path / "out" / INSTANCES).read_text() == "first"
    assert (tmp_path / "out.1" / INSTANCES).read_text() == "late"
    assert contents(tmp_path) == sorted(["out", f"out/{INSTANCES}", "out.1", f"out.1/{INSTANCES}"])


def test_a_second_writer_is_refused_with_the_process_that_writes(tmp_path):
    with RunFolder(tmp_path / "out"), pytest.raises(BadInput, match=f"written by process {os.getpid()}"):
        RunFolder(tmp_path / "out")
    assert contents(tmp_path) == []


@pytest.mark.parametrize("kind", ["folder of something else", "file", "link"])
def test_overwrite_refuses_what_is_not_a_run(tmp_path, kind):
    target = tmp_path / "out"
    if kind == "file":
        target.write_text("precious")
    elif kind == "link":
        make_run(tmp_path / "real")
        target.symlink_to(tmp_path / "real")
    else:
        target.mkdir()
        (target / "thesis.tex").write_text("precious")
    before = contents(tmp_path)
    with pytest.raises(BadInput, match="not overwritten"):
        RunFolder(target, overwrite=True)
    assert contents(tmp_path) == before


def test_an_empty_folder_may_be_overwritten(tmp_path):
    (tmp_path / "out").mkdir()
    make_run(tmp_path / "out", "new", overwrite=True)
    assert (tmp_path / "out" / INSTANCES).read_text() == "new"


def test_a_place_that_cannot_be_written_is_bad_input(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="cannot be written"), RunFolder(tmp_path / "file" / "out"):
        pass
    assert contents(tmp_path) == ["file"]


def test_leftovers_of_killed_runs_are_found(tmp_path):
    killed = tmp_path / ".out.partial-1234"
    killed.mkdir()
    with RunFolder(tmp_path / "out") as folder:
        assert folder.leftovers() == [killed]


def test_trajectory_lines_are_tum(tmp_path):
    quarter_turn_about_z = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], float)
    line = tum_text([1.5], [quarter_turn_about_z]).splitlines()[1]
    stamp, *numbers = map(float, line.split())
    half = np.sqrt(0.5)
    assert stamp == 1.5
    np.testing.assert_allclose(numbers, [1, 2, 3, 0, 0, half, half], atol=1e-8)


@pytest.mark.parametrize(("max_bad", "allowed"), [(0.5, 5), (0.0, 0), (0.29, 2), (1.0, 10)])
def test_the_run_gives_up_at_the_first_frame_beyond_the_allowed_share(max_bad, allowed):
    outcome = FrameAccounting("clip", planned=10, max_bad=max_bad)
    for index in range(allowed):
        outcome.skip(index, "broken")
    if allowed < 10:
        with pytest.raises(BadInput, match=rf"clip: {allowed + 1} of 10 frames .* frame 0: broken"):
            outcome.skip(allowed, "broken")
    else:
        with pytest.raises(BadInput, match="10 of 10"):
            outcome.require_used()


def test_of_several_files_none_is_replaced_if_one_cannot_be_written(tmp_path):
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    first.write_text("old")

    def fail(path):
        path.write_text("half")
        raise OSError("no space left")

    with pytest.raises(OSError, match="no space left"):
        replace_files({first: lambda path: path.write_text("new"), second: fail})
    assert first.read_text() == "old"
    assert list(tmp_path.iterdir()) == [first]
    replace_files({first: lambda path: path.write_text("new"), second: lambda path: path.write_text("newer")})
    assert (first.read_text(), second.read_text()) == ("new", "newer")
