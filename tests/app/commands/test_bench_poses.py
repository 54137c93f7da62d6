"""`razer bench poses` from the outside, on short walks."""

from __future__ import annotations

import json

import pytest

from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.report import COLUMNS, by_world
from app.benchmark.poses.worlds.hard_worlds import N_FRAMES, WORLDS
from app.cli import app
from slam.system import SlamSystem
from tests.support.cli import razer


def test_each_world_and_seed_is_a_run_with_its_figures(capsys):
    arguments = ("bench", "poses", "--worlds", "stride-8,fast-turns", "--seed", "2,1", "--frames", "24", "--json")
    code, out, err = razer(capsys, *arguments)
    assert code == 0
    document = json.loads(out.splitlines()[-1])
    assert (document["format"], document["seeds"], document["frames"]) == (1, [2, 1], 24)
    runs = [(run["world"], run["seed"], run["frames"]) for run in document["runs"]]
    assert runs == [("stride-8", 2, 6), ("stride-8", 1, 6), ("fast-turns", 2, 24), ("fast-turns", 1, 24)]
    for run in document["runs"]:
        assert run["share_tracked"] == run["share_in_time"] == 1
        assert (run["recoveries"], run["frames_to_recover"], run["false_ties"]) == (0, 0, 0)
        assert 0 < run["ate_cm"] < 10
        assert 0 < run["rotation_deg"] < 5
        assert run["cpu_ms"] > 0
        assert run["p95_to_plain"] > run["to_plain"] / 2 > 0
        assert 0 < run["end_share"] < 1
    assert "fast-turns" in err


def test_the_table_has_a_line_for_each_world(capsys):
    code, out, _ = razer(capsys, "bench", "poses", "--worlds", "stride-16", "--seeds", "1", "--frames", "16")
    assert code == 0
    assert "stride-16" in out
    assert "tracked" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--worlds", "nowhere"), "no world 'nowhere': choose from stride-1"),
        (("--worlds", "dark,"), "no world ''"),
        (("--seed", "1,x"), "--seed 1,x: give whole numbers"),
        (("--seed", "-1"), "give whole numbers"),
        (("--frames", "-4"), "--frames -4: give 0 or more"),
    ],
)
def test_what_cannot_be_measured_is_refused_in_a_line(arguments, message, capsys):
    code, out, err = razer(capsys, "bench", "poses", *arguments)
    assert (code, out) == (2, "")
    assert message in err.splitlines()[-1]


def test_a_recording_takes_the_place_of_worlds(capsys, tmp_path):
    folder = tmp_path / "clip"
    assert razer(capsys, "synth", str(folder), "--frames", "40", "--size", "160x120")[0] == 0
    code, out, _ = razer(capsys, "bench", "poses", str(folder), "--worlds", "cut,recorded", "--seed", "1", "--json")
    assert code == 0
    runs = json.loads(out.splitlines()[-1])["runs"]
    assert [run["world"] for run in runs] == ["cut", "recorded"]
    assert (runs[1]["frames"], runs[1]["share_tracked"]) == (40, 1)
    for arguments, message in (
        (("--worlds", "dark"), "no world 'dark': choose from recorded"),
        (("--calibration",), "--calibration is of synthetic worlds"),
    ):
        code, out, err = razer(capsys, "bench", "poses", str(folder), *arguments)
        assert (code, out) == (2, "")
        assert message in err.splitlines()[-1]


def test_a_folder_is_still_measured_and_poses_is_a_command_beside(capsys):
    folder, *_ = app.parse_args(["bench", "./poses", "--frames", "3"], exit_on_error=False, print_error=False)
    world, *_ = app.parse_args(["bench", "poses", "--frames", "3"], exit_on_error=False, print_error=False)
    assert (folder.__name__, world.__name__) == ("bench", "poses")
    _, shown, _ = razer(capsys, "bench", "poses", "--help")
    assert f"between: {', '.join(WORLDS)}." in " ".join(shown.replace("│", " ").split())


def row(world: str, seed: int, **figures: float | None) -> dict:
    usual = {"share_tracked": 1.0, "frames_to_recover": 0, "false_ties": 0, "ate_cm": 1.0, "rotation_deg": 0.5}
    return {
        "world": world,
        "seed": seed,
        **usual,
        "cpu_ms": 30.0,
        "to_plain": 1.5,
        "end_share": 0.2,
        "nees": 6.0,
        **figures,
    }


def test_the_table_says_the_worst_of_the_seeds_as_well():
    rows = [
        row("dark", 1, share_tracked=0.5, frames_to_recover=None, false_ties=3, ate_cm=1e38),
        row("dark", 2, frames_to_recover=12, false_ties=1, ate_cm=2.0, nees=None),
        row("dark", 3, cpu_ms=60.0, to_plain=2.5, end_share=0.5, nees=0.04),
        row("vga", 1, frames_to_recover=None, ate_cm=None),
    ]
    cells = {world: [cell(runs) for cell in COLUMNS.values()] for world, runs in by_world(rows).items()}
    assert cells["dark"] == [
        "83 (50)", "12, never in 1", "4", "2.0 (>1000)", "0.50 (0.50)", "40", "1.5 (2.5)", "30", "3.0 (6.0)",
    ]  # fmt: skip
    assert cells["vga"][0] == "100"
    assert cells["vga"][1:4] == ["never in 1", "0", "-"]


@pytest.mark.full
def test_a_camera_that_is_blind_for_a_second_is_found_again():
    walk = WORLDS["blind-1s"].walk(1, N_FRAMES // 2)
    figures = follow(walk, SlamSystem()).figures(walk.frames_per_s)
    assert figures["frames"] == len([index for index in walk.order if index is not None])
    assert figures["recoveries"] == 2
    assert figures["share_tracked"] > 0.95
    assert figures["ate_cm"] < 5
