"""Each verb from the outside: what it prints, what it leaves on disk, how it refuses."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib

import cv2
import numpy as np
import pytest

from app.cli import main
from app.profiling.cores import leave_cores_to_helpers
from app.settings.config_file import read_config
from app.settings.run_config import RunConfig
from app.timeline import viewer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.storage.ply import read_mesh_ply

N_FRAMES = 12
RUN_FILES = {
    "config.toml", "trajectory.txt", "mesh.ply", "mesh.glb", "instances.json", "embeddings.npz", "map.npz",
    "timings.json", "timeline.rrd",
}  # fmt: skip
QUICK = ("--set", "voxels.voxel_size_m=0.05", "--device", "cpu")
# A segmenter that finds nothing, tells how often it was asked, and takes its time.
SLOW_SEGMENTER = """
import time
from pathlib import Path
from razer.frame import Masks

class Slow:
    def __init__(self, log, wait_s=0.0, fail_at=None):
        self.log, self.wait_s, self.fail_at, self.asked = Path(log), wait_s, fail_at, 0

    def segment(self, frame):
        self.asked += 1
        self.log.write_text(str(self.asked))
        if self.asked == self.fail_at:
            raise RuntimeError("a bug in a plug-in")
        time.sleep(self.wait_s)
        return Masks.none(*frame.depth.shape)
"""


def write_recording(folder, *, poses=True, intrinsics=True, n_frames=N_FRAMES):
    """A small synthetic room in the project's own folder format, written independently of the project's writer."""
    room = SyntheticRoom(n_frames=n_frames, width=160, height=120)
    for name in ("color", "depth"):
        (folder / name).mkdir(parents=True)
    camera = room.intrinsics
    if intrinsics:
        numbers = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
        (folder / "intrinsics.json").write_text(json.dumps(numbers | {"depth_scale": 1000.0}))
    lines = []
    for index in range(n_frames):
        frame = room[index]
        cv2.imwrite(str(folder / f"color/{index:06d}.png"), frame.rgb[..., ::-1])
        cv2.imwrite(str(folder / f"depth/{index:06d}.png"), np.rint(frame.depth * 1000).astype(np.uint16))
        lines.append(tum_line(index / 30, frame.pose))
    if poses:
        (folder / "trajectory.txt").write_text("\n".join(lines) + "\n")
    return folder


def tum_line(stamp, pose):
    rotation, w = pose[:3, :3], np.sqrt(max(1e-12, 1 + np.trace(pose[:3, :3]))) / 2
    x, y, z = (rotation[i, j] - rotation[j, i] for i, j in ((2, 1), (0, 2), (1, 0)))
    values = (*pose[:3, 3], *(np.array([x, y, z]) / (4 * w)), w)
    return f"{stamp:.6f} " + " ".join(f"{value:.9f}" for value in values)


def razer(capsys, *arguments):
    """Run a command in this process; returns exit code, standard output, standard error."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return stopped.value.code or 0, out, err


def listing(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_recording(tmp_path_factory.mktemp("recording"))


@pytest.fixture(scope="module")
def finished(recording, tmp_path_factory):
    """A finished run made by the real program: (folder, its process)."""
    out = tmp_path_factory.mktemp("runs") / "new" / "run"
    command = [sys.executable, "-m", "app.cli", "run", recording, "-o", out, "--json", *QUICK]
    return out, subprocess.run(command, capture_output=True, text=True, check=True)


# Help


@pytest.mark.parametrize(
    ("cores", "told", "expected"), [(2, None, "1"), (16, None, "14"), (None, None, "1"), (8, "3", "3")]
)
def test_helpers_get_cores_of_their_own(cores, told, expected, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    monkeypatch.setenv("OMP_NUM_THREADS", told or "")
    if not told:
        monkeypatch.delenv("OMP_NUM_THREADS")
    leave_cores_to_helpers()
    assert os.environ["OMP_NUM_THREADS"] == expected


def test_help_lists_the_verbs_without_importing_them():
    code = (
        "import sys, app.cli\n"
        "try: app.cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'torch', 'open3d', 'cv2', 'rerun', 'pydantic', 'app.commands.map.run'} & set(sys.modules)\n"
        "print('imported:', sorted(heavy))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "imported: []" in shown
    for verb in ("run", "view", "config", "bench", "demo"):
        assert f" {verb} " in shown


# run


def test_the_last_line_of_a_json_run_is_the_contract(finished, recording):
    out, process = finished
    (line,) = process.stdout.splitlines()
    result = json.loads(line)
    keys = {"format", "run", "frames", "used", "skipped", "lost", "lost_intervals", "instances", "timings"}
    assert set(result) == keys
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
    assert config == read_config(None, given, {})


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
    folder = write_recording(tmp_path / "in", n_frames=8)
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


# What cannot be used: exit 2, one plain line, nothing left


def broken_recording(folder, n_broken):
    write_recording(folder, n_frames=6)
    for index in range(n_broken):
        (folder / f"depth/{index:06d}.png").write_bytes(b"")
    return folder


def recording_with_bad_poses(folder):
    write_recording(folder, n_frames=6)
    lines = [f"{index / 30:.6f} 0 0 0 0 0 0 0" for index in range(6)]
    (folder / "trajectory.txt").write_text("\n".join(lines))


INPUTS = {
    "good": write_recording,
    "missing": lambda folder: folder,
    "empty": lambda folder: folder.mkdir(),
    "no poses": lambda folder: write_recording(folder, poses=False, n_frames=3),
    "no intrinsics": lambda folder: write_recording(folder, intrinsics=False, n_frames=3),
    "all broken": lambda folder: broken_recording(folder, 6),
    "bad poses": recording_with_bad_poses,
    "most broken": lambda folder: broken_recording(folder, 4),
}


@pytest.mark.parametrize(
    ("folder", "options", "message"),
    [
        ("missing", (), "in"),
        ("empty", (), "empty"),
        ("no poses", ("--poses", "given"), "no camera poses"),
        ("no poses", ("--poses", "given"), "trajectory.txt"),
        ("no intrinsics", (), "intrinsics"),
        ("all broken", (), "holds no usable frame"),
        ("bad poses", (), "4 of 6 frames cannot be used, first frame 0: trajectory.txt"),
        ("bad poses", ("--max-bad", "1"), "6 of 6 frames cannot be used, first frame 0: trajectory.txt"),
        ("most broken", (), "4 of 6 frames cannot be used, first frame 0: .*000000.png"),
        (
            "good",
            ("--set", "voxels.voxelsize=0.1"),
            "unknown setting voxels.voxelsize; did you mean voxels.voxel_size_m",
        ),
        ("good", ("--set", "voxels.voxel_size_m=9"), "voxels.voxel_size_m = 9"),
        ("good", ("--config", "no-such.toml"), "no-such.toml"),
        ("good", ("--reader", "holograms"), "unknown reader 'holograms'"),
        ("good", ("--segmenter", "psychic"), "unknown segmenter 'psychic'"),
        ("good", ("--set", "segmenter.options.nonsense=1"), "segmenter 'geometric' does not take"),
        ("good", ("--intrinsics", "1,2"), "intrinsics"),
        ("good", ("--stride", "0"), "input.stride = 0"),
    ],
)
def test_unusable_input_is_one_plain_line(capsys, tmp_path, folder, options, message):
    INPUTS[folder](tmp_path / "in")
    before = listing(tmp_path)
    code, out, err = razer(capsys, "run", tmp_path / "in", "-o", tmp_path / "deep" / "run", *QUICK, *options)
    assert (code, out) == (2, "")
    lines = [line for line in err.splitlines() if line.startswith("razer: ")]
    assert len(lines) == 1
    assert lines[0] == err.splitlines()[-1]
    assert "Traceback" not in err
    assert re.search(message, lines[0]), lines[0]
    assert listing(tmp_path) == before


@pytest.mark.parametrize(
    "arguments",
    [("rn",), ("run",), ("run", "in", "-o", "x", "--poses", "perhaps"), ("run", "in", "-o", "x", "--strid", "2")],
)
def test_wrong_usage_is_exit_2(capsys, arguments):
    code, _, err = razer(capsys, *arguments)
    assert code == 2
    assert "Traceback" not in err


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


# A run that ends early


def start_slow_run(recording, tmp_path, **options):
    """A run in a process of its own whose segmenter is slow; returns the process and its count of frames."""
    (tmp_path / "slow_segmenter.py").write_text(SLOW_SEGMENTER)
    log = tmp_path / "asked"
    settings = [f"segmenter.options.{name}={value}" for name, value in {"log": log, **options}.items()]
    command = [sys.executable, "-m", "app.cli", "run", recording, "-o", tmp_path / "runs" / "run", "--json", *QUICK]
    command += ["--segmenter", "slow_segmenter:Slow", *(part for setting in settings for part in ("--set", setting))]
    (tmp_path / "runs").mkdir()
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": paths}
    )
    return process, log


def wait_for_frames(process, log, frames):
    while process.poll() is None:
        if log.exists() and int(log.read_text() or 0) >= frames:
            return
        time.sleep(0.02)
    pytest.fail(f"the run ended early: {process.communicate()}")


def test_a_killed_run_leaves_nothing_under_a_final_name(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=0.2)
    wait_for_frames(process, log, 3)
    process.kill()
    process.communicate()
    (left,) = (tmp_path / "runs").iterdir()
    assert left.name.startswith(".run.partial-")


def test_ctrl_c_finishes_the_folder_with_what_is_there(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=0.2)
    wait_for_frames(process, log, 3 + 3)  # up to three frames are looked at ahead
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130, err
    result = json.loads(out.splitlines()[-1])
    assert 3 <= result["used"] < N_FRAMES
    assert result["frames"] == result["used"]
    run = tmp_path / "runs" / "run"
    assert set(listing(run)) == RUN_FILES
    assert len(np.loadtxt(run / "trajectory.txt")) == result["used"]
    assert len(result["timings"]["rss_mb_at_tenths"]) == 10
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["run"]


def test_a_run_stopped_before_its_first_frame_leaves_nothing(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=60)
    wait_for_frames(process, log, 1)
    process.send_signal(signal.SIGINT)
    time.sleep(0.1)  # signals of one kind that arrive together count once
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in err
    assert listing(tmp_path / "runs") == []


def test_an_unknown_error_keeps_its_traceback_and_leaves_nothing(recording, tmp_path):
    process, _ = start_slow_run(recording, tmp_path, fail_at=2)
    _, err = process.communicate()
    assert process.returncode == 1
    assert "a bug in a plug-in" in err
    assert "Traceback" in err
    assert listing(tmp_path / "runs") == []


# config, bench, demo, view


def test_config_prints_every_setting_in_three_ways(capsys, tmp_path):
    changed = ("--set", "voxels.voxel_size_m=0.013")
    _, text, _ = razer(capsys, "config", *changed)
    assert "voxels.voxel_size_m = 0.013   [> 0.001 and <= 0.2] (changed)" in text
    _, as_json, _ = razer(capsys, "config", *changed, "--json")
    values = {setting["name"]: setting["value"] for setting in json.loads(as_json)}
    assert values["voxels.voxel_size_m"] == 0.013
    assert all(f"{name} = " in text for name in values)
    _, toml, _ = razer(capsys, "config", *changed, "--toml")
    assert tomllib.loads(toml)["voxels"]["voxel_size_m"] == 0.013
    (tmp_path / "a.toml").write_text(toml)
    assert razer(capsys, "config", "--config", tmp_path / "a.toml", "--toml")[1] == toml
    assert set(RunConfig.model_fields) == set(tomllib.loads(toml))


def test_bench_measures_stages_beside_the_yardstick(recording, tmp_path):
    command = [sys.executable, "-m", "app.cli", "bench", recording, "--json", "--max-frames", "6", *QUICK]
    process = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    result = json.loads(process.stdout.splitlines()[-1])
    assert (result["frames"], result["repeat"]) == (6, 1)
    assert sum(stage["share"] for stage in result["stages"].values()) == pytest.approx(1, abs=0.01)
    plain = result["yardstick"]
    assert 0 < plain["median_ms"] <= plain["p95_ms"]
    ratio = result["stages"]["integrate"]["total_s"] / plain["total_s"]
    assert result["ratios"]["integrate"] == pytest.approx(ratio, rel=0.02)
    assert result["ratios"]["backend"] > result["ratios"]["integrate"]
    assert len(result["rss_mb_at_tenths"]) == 10
    assert result["synth"]["fps"] > 0
    assert result["evaluation"]["cpu_s"] > 0
    assert result["yolo_decoding"]["masks"] == 30
    assert result["yolo_decoding"]["median_ms"] > 0
    assert min(result["describing"].values()) > 0
    assert result["ranking"]["query_ms"] > 0
    assert listing(tmp_path) == []


def test_demo_names_things_of_the_simulated_room(capsys, tmp_path):
    target = tmp_path / "demo"
    code, out, _ = razer(capsys, "demo", "-o", target, "--frames", 8, "--set", "voxels.voxel_size_m=0.05")
    assert code == 0
    assert "simulator" in out
    named = {item["class"] for item in json.loads((target / "instances.json").read_text())["instances"]}
    assert len(named - {None}) >= 3
    assert named - {None} <= set(SyntheticRoom(n_frames=1, width=16, height=12).classes.values())
    assert set(listing(target)) == RUN_FILES


def test_view_opens_the_timeline_of_a_run(capsys, monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr(viewer, "open_viewer", lambda path, web: opened.append((path, web)))
    (tmp_path / "timeline.rrd").write_bytes(b"")
    assert razer(capsys, "view", tmp_path, "--web")[0] == 0
    assert opened == [(tmp_path / "timeline.rrd", True)]


def test_view_without_a_timeline_is_bad_input(capsys, tmp_path):
    code, _, err = razer(capsys, "view", tmp_path)
    assert code == 2
    assert "timeline.rrd does not exist" in err
