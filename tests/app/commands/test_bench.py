"""`razer bench` from the outside."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from tests.support.cli import QUICK, listing, razer, write_small_room


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("recording"))


@pytest.mark.full
def test_bench_measures_stages_beside_the_yardstick(recording, tmp_path):
    command = [sys.executable, "-m", "app", "bench", recording, "--json", "--max-frames", "6", *QUICK]
    process = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    result = json.loads(process.stdout.splitlines()[-1])
    assert (result["frames"], result["repeat"]) == (6, 1)
    assert sum(stage["share"] for stage in result["stages"].values()) == pytest.approx(1, abs=0.01)
    plain = result["yardstick"]
    assert 0 < plain["median_ms"] <= plain["p95_ms"]
    ratio = result["stages"]["integrate"]["total_s"] / plain["total_s"]
    assert result["ratios"]["integrate"] == pytest.approx(ratio, rel=0.02)
    assert result["ratios"]["backend"] > result["ratios"]["integrate"]
    cpu = result["backend_cpu"]
    assert cpu["frames"] == 6
    assert cpu["to_plain"] == pytest.approx(cpu["cpu_ms"] / cpu["plain_cpu_ms"], rel=0.02)
    assert cpu["to_plain"] > 1  # the map does all that plain fusion does
    assert len(result["rss_mb_at_tenths"]) == 10
    assert result["synth"]["fps"] > 0
    assert result["evaluation"]["cpu_s"] > 0
    assert result["evaluation"]["read_to_looking"] > 0
    assert result["yolo_decoding"]["masks"] == 30
    assert result["yolo_decoding"]["median_ms"] > 0
    assert min(result["describing"].values()) > 0
    assert result["ranking"]["query_ms"] > 0
    assert result["registering"]["to_remap"] > 0
    assert listing(tmp_path) == []


@pytest.mark.full
def test_bench_measures_a_run_whose_poses_are_estimated_and_corrected(recording, tmp_path):
    command = [sys.executable, "-m", "app", "bench", recording, "--json", "--poses", "slam", *QUICK]
    process = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    result = json.loads(process.stdout.splitlines()[-1])
    assert result["stages"]["pose"]["total_s"] > result["stages"]["integrate"]["total_s"] / 100
    assert result["stages"]["rebuild"]["total_s"] > 0


@pytest.fixture(scope="module")
def parted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parted") / "room"
    write_folder(SyntheticRoom(0, n_frames=6, width=160, height=120), folder)
    return folder


def test_bench_measures_the_masks_of_a_segmenter(parted, capsys):
    code, out, _ = razer(capsys, "bench", parted, "--masks", "--json", "--oracle", "none")
    assert code == 0
    perfect = json.loads(out.splitlines()[-1])
    assert (perfect["format"], perfect["views"], perfect["segmenter"]) == (1, 6, "oracle")
    assert perfect["renamed"] == 0
    assert perfect["iou"] > 0.8
    code, out, _ = razer(capsys, "bench", parted, "--masks", "--json", "--oracle", "sam")
    sam = json.loads(out.splitlines()[-1])
    assert sam.keys() == perfect.keys()
    assert sam["missed"] > perfect["missed"] + 0.1
    code, out, _ = razer(capsys, "bench", parted, "--masks", "--oracle", "none", "--stride", "2")
    assert code == 0
    assert "masks a view" in out


def test_bench_measures_what_a_segmenter_recognises(parted, recording, capsys):
    code, out, _ = razer(capsys, "bench", parted, "--recognition", "--json", "--oracle", "none")
    assert code == 0
    perfect = json.loads(out.splitlines()[-1])
    assert (perfect["format"], perfect["frames"], perfect["recall"]) == (1, 6, 1)
    assert perfect["surfaces"]["wall"] > 0.98
    assert perfect["things"]["chair"]["seen"] == perfect["things"]["chair"]["found"] > 0
    code, out, _ = razer(capsys, "bench", parted, "--recognition", "--json", "--oracle", "detector-hard")
    assert json.loads(out.splitlines()[-1])["recall"] < 1
    code, out, _ = razer(capsys, "bench", parted, "--recognition", "--oracle", "none", "--stride", "3")
    assert "IoU of wall" in out
    for arguments, message in (
        (("bench", "--recognition"), "razer bench FOLDER --recognition"),
        (("bench", recording, "--recognition", "--segmenter", "geometric"), "no instance ids"),
    ):
        code, _, err = razer(capsys, *arguments)
        assert code == 2
        assert message in err.splitlines()[-1]


def test_a_recording_without_parts_is_said_in_one_line(parted, tmp_path):
    folder = tmp_path / "older"
    shutil.copytree(parted, folder)
    shutil.rmtree(folder / "parts")
    command = [sys.executable, "-m", "app", "bench", folder, "--masks", "--oracle", "sam", "--max-frames", "2"]
    process = subprocess.run(command, capture_output=True, text=True, check=True)
    said = [line for line in process.stderr.splitlines() if "no parts/" in line]
    assert len(said) == 1
    assert said[0].startswith("WARNING: the recording has no parts/")


def test_masks_need_a_recording_with_ids(recording, capsys):
    for arguments, message in (
        (("bench", "--masks"), "razer bench FOLDER --masks"),
        (("bench", recording, "--masks", "--oracle", "sam"), "no instance ids"),
        (("bench", recording, "--masks", "--oracle", "sam", "--embedder", "oracle"), "leave them out"),
    ):
        code, _, err = razer(capsys, *arguments)
        assert code == 2, arguments
        assert message in err.splitlines()[-1]


def test_bench_measures_a_library(capsys):
    code, out, err = razer(capsys, "bench", "library", "--instances", "1000", "--queries", "2", "--json")
    assert code == 0, err
    result = json.loads(out.splitlines()[-1])
    assert (result["format"], result["instances"], result["maps"]) == (1, 1000, 10)
    assert all(row["recall_at_10"] == 1 for row in result["nearest"].values())  # nothing is indexed
    assert result["answers"].keys() == {"text", "picture"}
    assert "at least 1000" in razer(capsys, "bench", "library", "--instances", "10")[2]
