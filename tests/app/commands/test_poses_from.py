"""Poses of another program, as `run`, `inspect`, `track` and `convert` take them; and given poses, corrected."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest

from data_tools import open_sequence
from tests.support.cli import N_FRAMES, QUICK, call, razer, write_small_room
from tests.support.drifting_poses import noisy
from tests.support.pose_files import write_kitti, write_tum_lines

MODELS = ("--segmenter", "geometric", "--embedder", "appearance", "--no-timeline", *QUICK)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("elsewhere") / "room")


@pytest.fixture(scope="module")
def true_poses(recording):
    return [frame.pose for frame in open_sequence(recording)]


@pytest.fixture(scope="module")
def elsewhere(recording, true_poses):
    """A KITTI file of the true poses in another world, 3 m to the side."""
    moved = [pose.copy() for pose in true_poses]
    for pose in moved:
        pose[0, 3] += 3
    return write_kitti(recording.parent / "kitti.txt", moved)


def test_a_file_of_poses_stands_for_those_of_the_recording(recording, true_poses, elsewhere, tmp_path, capsys):
    code, _, err = razer(capsys, "run", recording, "-o", tmp_path / "run", "--poses", elsewhere, *MODELS)
    assert code == 0
    assert f"poses from kitti.txt (KITTI, a line a frame): {N_FRAMES} of {N_FRAMES} frames have one" in err
    rows = np.loadtxt(tmp_path / "run" / "trajectory.txt")
    np.testing.assert_allclose(rows[:, 1], [3 + pose[0, 3] for pose in true_poses], atol=1e-6)
    settings = tomllib.loads((tmp_path / "run" / "config.toml").read_text())["input"]
    assert (settings["poses"], settings["poses_from"]) == ("given", str(elsewhere))


def test_other_verbs_take_the_file_too(recording, true_poses, elsewhere, tmp_path, capsys):
    code, out, err = razer(capsys, "inspect", recording, "--poses-from", elsewhere, "--json")
    assert (code, "poses from kitti.txt" in err) == (0, True)
    assert json.loads(out.splitlines()[-1])["poses"]["share"] == 1.0
    assert razer(capsys, "convert", recording, tmp_path / "copy", "--poses-from", elsewhere)[0] == 0
    assert open_sequence(tmp_path / "copy")[4].pose[0, 3] == pytest.approx(3 + true_poses[4][0, 3], abs=1e-6)


@pytest.mark.full
def test_refined_poses_are_reported_by_run_and_compare(recording, true_poses, tmp_path, capsys):
    given = noisy(true_poses, np.random.default_rng(4))
    path = write_tum_lines(tmp_path / "noisy.txt", [i / 30 for i in range(N_FRAMES)], given)
    options = ("--poses", "refine", "--poses-from", path, *MODELS, "--json")
    code, out, _ = razer(capsys, "run", recording, "-o", tmp_path / "refined", *options)
    assert code == 0
    corrected = json.loads(out.splitlines()[-1])["corrected"]
    kept, refined = (np.loadtxt(tmp_path / "refined" / name) for name in ("given_trajectory.txt", "trajectory.txt"))
    np.testing.assert_allclose(kept[:, 1:4], [pose[:3, 3] for pose in given], atol=1e-6)
    moved_m = np.linalg.norm(refined[:, 1:4] - kept[:, 1:4], axis=1)
    assert corrected["frames"] == N_FRAMES
    assert corrected["median_m"] == pytest.approx(np.median(moved_m), abs=1e-6)
    assert corrected["max_m"] == pytest.approx(moved_m.max(), abs=1e-6)
    assert 0 < corrected["median_deg"] <= corrected["max_deg"] < 2
    assert call("run", recording, "-o", tmp_path / "given", "--poses-from", path, *MODELS) == 0
    capsys.readouterr()
    code, out, _ = razer(capsys, "compare", tmp_path / "given", tmp_path / "refined", "--json")
    said = json.loads(out.splitlines()[-1])["corrected"]
    assert (code, said.keys()) == (0, {"b"})
    assert said["b"] == pytest.approx(corrected, abs=1e-6)
    code, out, _ = razer(capsys, "compare", tmp_path / "given", tmp_path / "refined")
    assert f"B: given poses were corrected by {100 * corrected['median_m']:.1f} cm" in out


def test_track_corrects_given_poses(recording, tmp_path, capsys):
    out_file = tmp_path / "refined.txt"
    code, out, _ = razer(capsys, "track", recording, "--poses", "refine", "-o", out_file, "--json")
    result = json.loads(out.splitlines()[-1])
    assert (code, result["used"], result["lost"]) == (0, N_FRAMES, 0)
    assert result["corrected"]["max_m"] < 0.01  # they were true
    assert len(np.loadtxt(out_file)) == N_FRAMES
    code, out, err = razer(capsys, "track", recording, "--poses", "refine")
    assert "corrected: given poses were corrected by 0." in out  # centimetres: they were true
    assert err.count("--poses") == 1  # what to do next: map them so


def test_a_table_of_many_recordings_takes_no_file_of_poses(elsewhere, tmp_path, capsys):
    code, _, err = razer(capsys, "reproduce", "scenenn", tmp_path, "--poses", elsewhere)
    assert (code, "leave --poses FILE and --poses-from out" in err) == (2, True)
