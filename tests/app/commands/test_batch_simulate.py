"""`razer batch simulate`."""

from __future__ import annotations

import json

import pytest

from tests.support.cli import razer


@pytest.fixture
def report(tmp_path):
    scenes = [{"name": str(n), "status": "done", "history": [{"seconds": 60.0}]} for n in range(4)]
    path = tmp_path / "report.json"
    path.write_text(json.dumps({"format": 1, "scenes": scenes, "totals": {"engine_cpu_s": 0.0, "seconds": 121.0}}))
    return path


def test_a_batch_with_other_workers_is_simulated(report, capsys):
    _, out, _ = razer(capsys, "batch", "simulate", report, "--workers", 2, "--dispatch-s", 0, "--json")
    figures = json.loads(out)
    assert (figures["makespan_s"], figures["lower_bound_s"], figures["measured_s"]) == (120.0, 120.0, 121.0)
    code, out, _ = razer(capsys, "batch", "simulate", report, "--workers", 4, "--scenes", 400, "--dispatch-s", 0)
    assert code == 0
    assert "makespan_s: 6000.0" in out


@pytest.mark.parametrize("words", [("--workers", 0), ("--workers", 2, "--scenes", 0)])
def test_nobody_and_nothing_is_simulated(report, words, capsys):
    code, _, err = razer(capsys, "batch", "simulate", report, *words)
    assert code == 2
    assert len(err.splitlines()) == 1
