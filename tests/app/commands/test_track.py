"""`razer track`, and `razer run` under estimated poses: what they write and say, and where their settings come from."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

from tests.support.cli import call, razer


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("track") / "clip"
    assert call("synth", folder, "--scene", "tabletop", "--frames", "100", "--size", "320x240") == 0
    return folder


def test_track_writes_both_trajectories_and_the_contract(clip, tmp_path, capsys):
    files = (tmp_path / "final.txt", tmp_path / "live.txt")
    options = ("-o", files[0], "--live-poses", files[1], "--stride", "2", "--max-frames", "12", "--json")
    code, out, _ = razer(capsys, "track", clip, *options)
    assert code == 0
    result = json.loads(out.splitlines()[-1])
    assert set(result) == {
        "frames", "used", "skipped", "lost", "lost_intervals", "tracked", "asked", "interrupted", "keyframes", "loops",
        "open", "ms_median", "ms_p95", "ate_rmse_m", "rotation_rmse_deg", "rpe_trans_m", "rpe_rot_deg", "aligned_by",
        "degenerate",
    }  # fmt: skip
    assert (result["frames"], result["used"], result["tracked"], result["lost_intervals"]) == (12, 12, 1.0, [])
    assert (result["rotation_rmse_deg"] < 1.5, result["aligned_by"] in ("positions", "orientations")) == (True, True)
    assert result["ate_rmse_m"] < 0.03
    for file in files:
        rows = np.loadtxt(file)
        assert rows.shape == (12, 8)
        np.testing.assert_allclose(np.linalg.norm(rows[:, 4:], axis=1), 1, atol=1e-6)


def test_track_loads_nothing_of_mapping(clip, tmp_path):
    """Half a gigabyte and seconds, which a camera's path never needs."""
    arguments = ["track", str(clip), "-o", str(tmp_path / "path.txt"), "--max-frames", "2"]
    code = (
        "import sys, app.cli\n"
        f"try: app.cli.main({arguments!r})\n"
        "except SystemExit as ending: print('ended:', ending.code)\n"
        "print('imported:', sorted({'torch', 'open3d', 'rerun', 'onnxruntime', 'matplotlib'} & set(sys.modules)))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "ended: 0" in shown
    assert "imported: []" in shown


def test_track_takes_settings_from_the_command_line_and_from_a_file(clip, tmp_path, capsys):
    options = ("--max-frames", "8", "--json")
    counts = []
    (tmp_path / "often.toml").write_text("[slam.keyframes]\nmax_shift_m = 0.001\n")
    for settings in ((), ("--set", "slam.keyframes.max_shift_m=0.001"), ("--config", tmp_path / "often.toml")):
        code, out, _ = razer(capsys, "track", clip, *options, *settings)
        assert code == 0
        counts.append(json.loads(out.splitlines()[-1])["keyframes"])
    assert counts[0] < counts[1] == counts[2] == 8
    code, _, err = razer(capsys, "track", clip, "--set", "slam.keyframes.max_shift=1")
    assert code == 2
    assert "slam.keyframes.max_shift_m" in err


def test_a_folder_without_poses_becomes_a_map_that_follows(clip, tmp_path, capsys):
    shutil.copytree(clip, tmp_path / "clip", ignore=shutil.ignore_patterns("trajectory.txt", "truth"))
    options = ("--no-timeline", "--max-frames", "12", "--json")
    code, out, _ = razer(capsys, "run", tmp_path / "clip", "-o", tmp_path / "run", *options)
    assert code == 0
    result = json.loads(out.splitlines()[-1])
    assert (result["used"], result["lost"]) == (12, 0)
    trajectory = np.loadtxt(tmp_path / "run" / "trajectory.txt")
    assert len(trajectory) == 12
    kept = np.load(tmp_path / "run" / "pose_covariances.npz")
    assert set(kept["stamps"].round(6)) <= set(trajectory[:, 0])
    assert kept["covariances"].shape == (len(kept["frames"]), 6, 6) != (0, 6, 6)
    assert (np.linalg.eigvalsh(kept["covariances"]) > 0).all()


@pytest.mark.full
def test_both_are_two_runs_and_their_comparison(clip, tmp_path, capsys):
    options = ("--poses", "both", "--no-timeline", "--max-frames", "8", "--json")
    code, out, _ = razer(capsys, "run", clip, "-o", tmp_path / "out", *options)
    assert code == 0
    result = json.loads(out.splitlines()[-1])
    assert result["pose"]["ate_rmse_m"] < 0.03
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"given", "slam", "compare"}
    assert (tmp_path / "out" / "compare" / "trajectories.png").exists()
    assert razer(capsys, "run", clip, "-o", tmp_path / "out", *options)[0] == 2  # nothing is overwritten unasked


def test_only_a_run_is_made_with_both(clip, tmp_path, capsys):
    code, _, err = razer(capsys, "bench", clip, "--poses", "both")
    assert code == 2
    assert "razer run" in err
