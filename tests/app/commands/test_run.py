"""`razer run` from the outside: what it prints, what it leaves on disk."""

from __future__ import annotations

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from app.settings.config_file import read_config
from razer.storage.ply import read_mesh_ply
from tests.support.cli import N_FRAMES, QUICK, RUN_FILES, listing, razer, write_small_room


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("recording"))


@pytest.fixture(scope="module")
def finished(recording, tmp_path_factory):
    """A finished run made by the real program: (folder, its process)."""
    out = tmp_path_factory.mktemp("runs") / "new" / "run"
    command = [sys.executable, "-m", "app", "run", recording, "-o", out, "--json", *QUICK]
    return out, subprocess.run(command, capture_output=True, text=True, check=True)


def test_the_last_line_of_a_json_run_is_the_contract(finished, recording):
    out, process = finished
    (line,) = process.stdout.splitlines()
    result = json.loads(line)
    account = {"frames", "used", "skipped", "lost", "lost_intervals", "tracked", "asked"}
    assert set(result) == {
        "format",
        "run",
        "instances",
        "parts",
        "timings",
        "rgbd",
        "rgbd_applied",
        "segmenter",
        "embedder",
        *account,
    }
    assert {key: result[key] for key in account} == result["timings"]["account"]
    assert (result["tracked"], result["asked"]) == (1.0, N_FRAMES)
    assert (result["format"], result["run"]) == (1, str(out))
    assert (result["frames"], result["used"], result["skipped"], result["lost"]) == (N_FRAMES, N_FRAMES, [], 0)
    instances = json.loads((out / "instances.json").read_text())["instances"]
    assert result["instances"] == len(instances) > 0
    assert result["timings"] == json.loads((out / "timings.json").read_text())
    assert f"{N_FRAMES}/{N_FRAMES} frames" in process.stderr


def test_a_run_folder_is_complete_and_nothing_else_is_left(finished):
    out, _ = finished
    assert set(listing(out)) == RUN_FILES
    assert [path.name for path in out.parent.iterdir()] == ["run"]


def test_timings_follow_the_contract(finished):
    timings = json.loads((finished[0] / "timings.json").read_text())
    assert {"frames", "wall_s", "fps", "peak_rss_mb", "rss_mb_at_tenths", "blocks_at_tenths", "stages"} <= set(timings)
    assert timings["frames"] == N_FRAMES
    assert timings["fps"] == pytest.approx(N_FRAMES / timings["wall_s"], rel=1e-2)
    stages = ["decode", "pose", "integrate", "segment", "embed", "lift", "associate", "vote", "maintain", "log"]
    assert list(timings["stages"]) == stages
    blocks = timings["blocks_at_tenths"]
    assert len(blocks) == len(timings["rss_mb_at_tenths"]) == 10
    assert blocks == sorted(blocks)
    assert blocks[0] > 0
    assert max(timings["rss_mb_at_tenths"]) <= timings["peak_rss_mb"]


def test_the_trajectory_is_the_one_that_was_given(finished, recording):
    written = np.loadtxt(finished[0] / "trajectory.txt")
    given = np.loadtxt(recording / "trajectory.txt")
    np.testing.assert_allclose(written[:, :4], given[:, :4], atol=1e-6)
    same_rotation = np.abs((written[:, 4:] * given[:, 4:]).sum(axis=1))
    np.testing.assert_allclose(same_rotation, 1, atol=1e-6)


def test_the_saved_config_is_the_one_that_was_used(finished, recording):
    config = read_config(finished[0] / "config.toml", [], {})
    assert config.voxels.voxel_size_m == 0.05
    assert config.run.device == "cpu"
    given = ["voxels.voxel_size_m=0.05", "run.device=cpu", "input.poses=given", f"input.folder={recording}"]
    models = ["segmenter.name=geometric", "embedder.name=appearance"]  # what "auto" stands for without weights
    assert config == read_config(None, given + models, {})


def test_mesh_and_instances_agree(finished):
    out, _ = finished
    mesh = read_mesh_ply(out / "mesh.ply")
    instances = json.loads((out / "instances.json").read_text())["instances"]
    counts = np.bincount(mesh.instances)
    assert {item["id"]: item["n_vertices"] for item in instances} == {
        item["id"]: (counts[item["id"]] if item["id"] < len(counts) else 0) for item in instances
    }


def test_without_json_a_table_tells_instances_and_place(capsys, recording, tmp_path):
    code, out, _ = razer(
        capsys, "run", recording, "-o", tmp_path / "run", *QUICK, "--no-timeline", "--stride", 2, "--max-frames", 4
    )
    assert code == 0
    assert set(listing(tmp_path / "run")) == RUN_FILES - {"timeline.rrd"}
    assert "4 of 4 frames used" in out
    assert str(tmp_path / "run") in out
    stamps = np.loadtxt(tmp_path / "run" / "trajectory.txt")[:, 0]
    np.testing.assert_allclose(stamps * 30, [0, 2, 4, 6], atol=1e-3)


def test_broken_frames_are_skipped_counted_and_named(capsys, tmp_path):
    folder = write_small_room(tmp_path / "in", n_frames=8)
    (folder / "depth/000002.png").write_bytes(b"not a png")
    (folder / "color/000005.png").write_bytes(b"")
    cv2.imwrite(str(folder / "depth/000003.png"), np.zeros((120, 160), np.uint16))
    lines = (folder / "trajectory.txt").read_text().splitlines()
    lines[6] = lines[6].split()[0] + " nan nan nan 0 0 0 1"
    (folder / "trajectory.txt").write_text("\n".join(lines))
    code, out, _ = razer(capsys, "run", folder, "-o", tmp_path / "run", *QUICK, "--no-timeline", "--json")
    result = json.loads(out.splitlines()[-1])
    assert (code, result["frames"], result["used"]) == (0, 8, 4)
    assert [entry["frame"] for entry in result["skipped"]] == [2, 3, 5, 6]
    assert "000002.png" in result["skipped"][0]["reason"]
    assert "depth" in result["skipped"][1]["reason"]
    assert "000005.png" in result["skipped"][2]["reason"]
    assert len(np.loadtxt(tmp_path / "run" / "trajectory.txt")) == 4


def test_a_suspicious_depth_scale_is_a_loud_warning(capsys, recording, tmp_path):
    wide = ("--set", "voxels.depth_max_m=50", "--set", "voxels.voxel_size_m=0.2", "--device", "cpu")
    arguments = ("run", recording, "-o", tmp_path / "run", "--max-frames", 2, "--no-timeline", *wide)
    code, _, err = razer(capsys, *arguments, "--depth-scale", 100)
    assert code == 0
    (warning,) = [line for line in err.splitlines() if "WARNING" in line]
    assert "100 units per metre" in warning
    assert "--depth-scale 1000" in warning
    assert "WARNING" not in razer(capsys, *arguments, "--overwrite")[2]


def test_an_existing_folder_needs_overwrite_and_survives_a_failing_one(capsys, recording, tmp_path):
    target = tmp_path / "run"
    arguments = ("run", recording, "-o", target, *QUICK, "--no-timeline", "--max-frames", 2)
    assert razer(capsys, *arguments)[0] == 0
    first = (target / "timings.json").read_text()
    code, _, err = razer(capsys, *arguments)
    assert code == 2
    assert "--overwrite" in err
    assert razer(capsys, *arguments, "--overwrite", "--segmenter", "psychic")[0] == 2
    assert (target / "timings.json").read_text() == first
    assert razer(capsys, *arguments, "--overwrite")[0] == 0
    assert (target / "timings.json").read_text() != first
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
