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


@pytest.mark.parametrize(
    "words",
    [
        ("--workers", 0),
        ("--scenes", 0),
        ("--straggler-share", 2),
        ("--straggler-share", "nan"),
        ("--straggler-times", 0.5),
        ("--hours-between-failures", -1),
        ("--restart-s", "inf"),
        ("--dispatch-s", -1),
    ],
)
def test_what_no_cluster_has_is_not_simulated(report, words, capsys):
    workers = () if words[0] == "--workers" else ("--workers", 2)
    code, _, err = razer(capsys, "batch", "simulate", report, *workers, *words)
    assert code == 2
    assert err.startswith(f"razer: {words[0]} ")
    assert len(err.splitlines()) == 1
