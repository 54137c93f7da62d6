"""`razer bench` from the outside."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.support.cli import QUICK, listing, write_small_room


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("recording"))


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
