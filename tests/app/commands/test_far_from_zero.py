"""A recording at coordinates such as UTM's: mapped, evaluated, compared and converted as the same one near zero."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.ply import read_ply
from data_tools.truth.ply_writer import write_ply
from data_tools.writers.own_folder import write_folder
from tests.support.cli import call, razer

pytestmark = pytest.mark.full

SHIFT = (5e6, 4e5, 120.0)
ORIGIN = [5e6, 4e5, 0.0]
QUICK = ("--segmenter", "oracle", "--embedder", "oracle", "--no-timeline", "--device", "cpu")


def shifted(near: Path, far: Path) -> Path:
    """A copy of a recording and its truth elsewhere in the world."""
    shutil.copytree(near, far)
    lines = [line.split() for line in (near / "trajectory.txt").read_text().splitlines()]
    for words in lines:
        words[1:4] = [f"{float(word) + shift:.9f}" for word, shift in zip(words[1:4], SHIFT, strict=True)]
    (far / "trajectory.txt").write_text("\n".join(map(" ".join, lines)) + "\n")
    path = far / "truth" / "mesh.ply"
    mesh = read_ply(path)
    labels = {name: mesh.vertices[name] for name in ("instance", "class", "visible")}
    write_ply(path, mesh.points(path).astype(np.float64) + SHIFT, labels, mesh.triangles)
    return far


@pytest.fixture(scope="module")
def worlds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """near and far: one recording at two places, and near_run and far_run."""
    place = tmp_path_factory.mktemp("worlds")
    room = SyntheticRoom(0, 16, 128, 96)
    write_folder(room, place / "near", truth=room.truth(spacing_m=0.05))
    shifted(place / "near", place / "far")
    for name in ("near", "far"):
        assert call("run", place / name, "-o", place / f"{name}_run", *QUICK, "--set", "voxels.voxel_size_m=0.05") == 0
    return place


def test_the_run_says_where_its_map_is(worlds: Path) -> None:
    assert json.loads((worlds / "far_run" / "world.json").read_text()) == {"format": 1, "world_from_map": ORIGIN}
    assert not (worlds / "near_run" / "world.json").exists()
    far, near = (np.loadtxt(worlds / f"{name}_run" / "trajectory.txt") for name in ("far", "near"))
    np.testing.assert_allclose(far[:, 1:4] + ORIGIN, near[:, 1:4] + SHIFT, atol=1e-6)


def test_evaluation_says_the_same_at_both_places(worlds: Path, capsys: pytest.CaptureFixture[str]) -> None:
    numbers = {}
    for name in ("near", "far"):
        code, out, _ = razer(capsys, "eval", worlds / f"{name}_run", "--truth", worlds / name, "--json")
        assert code == 0
        numbers[name] = json.loads(out)
    assert numbers["near"]["surface"]["fscore_5cm"] > 0.9
    for part, key in (("surface", "fscore_5cm"), ("surface", "accuracy_m"), ("class_agnostic", "ap50")):
        assert numbers["far"][part][key] == pytest.approx(numbers["near"][part][key], abs=0.01)


def test_runs_with_origins_of_their_own_are_compared_in_one_frame(
    worlds: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = shutil.copytree(worlds / "far_run", tmp_path / "other")
    rows = np.loadtxt(other / "trajectory.txt")
    # The same poses as seen from an origin a kilometre to the north, with a map that was not moved: a kilometre off.
    (other / "world.json").write_text(json.dumps({"format": 1, "world_from_map": [5e6, 4.01e5, 0.0]}))
    command = ("compare", worlds / "far_run", other, "-o", tmp_path / "out", "--json")
    code, out, _ = razer(capsys, *command)
    assert code == 0
    assert json.loads(out)["pose"]["a_from_b"][1][3] == pytest.approx(-1000.0)
    # And moved as that origin asks for: no difference.
    rows[:, 2] -= 1000.0
    np.savetxt(other / "trajectory.txt", rows, fmt="%.9f")
    code, out, _ = razer(capsys, *command)
    assert np.abs(np.array(json.loads(out)["pose"]["a_from_b"]) - np.eye(4)).max() < 1e-6
    truth = ("--truth", worlds / "far")
    code, out, _ = razer(
        capsys, "compare", worlds / "far_run", worlds / "far_run", "-o", tmp_path / "o2", "--json", *truth
    )
    assert code == 0
    assert json.loads(out)["a"]["surface"]["fscore_5cm"] > 0.9


def test_a_converted_recording_stays_where_it_is(worlds: Path, tmp_path: Path) -> None:
    assert call("convert", worlds / "far", tmp_path / "again", "--lossless") == 0
    was, now = (np.loadtxt(folder / "trajectory.txt")[:, 1:4] for folder in (worlds / "far", tmp_path / "again"))
    np.testing.assert_allclose(now, was, atol=1e-6)
    before, after = (
        read_ply(path).points(path) for path in (f / "truth/mesh.ply" for f in (worlds / "far", tmp_path / "again"))
    )
    assert after.dtype == np.float64
    np.testing.assert_array_equal(after, before)


def test_a_broken_world_file_is_one_line(worlds: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = shutil.copytree(worlds / "far_run", tmp_path / "run")
    (run / "world.json").write_text("{")
    code, _, err = razer(capsys, "eval", run, "--truth", worlds / "far")
    assert code == 2
    assert "world_from_map" in err.splitlines()[-1]
