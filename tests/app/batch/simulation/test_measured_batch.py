"""Measured batches that simulations begin with."""

from __future__ import annotations

import json

import numpy as np
import pytest

from app.batch.simulation.measured_batch import MeasuredBatch
from razer.errors import BadInput


def scene(name, status, *seconds):
    return {"name": name, "status": status, "history": [{"seconds": one} for one in seconds]}


@pytest.fixture
def report():
    scenes = [scene("a", "done", 99.0, 10.0), scene("b", "failed", 5.0), scene("c", "done", 30.0)]
    return {"format": 1, "scenes": scenes, "totals": {"engine_cpu_s": 0.5, "seconds": 130.0}}


def read(tmp_path, report):
    path = tmp_path / "report.json"
    path.write_text(json.dumps(report))
    return MeasuredBatch.read(path)


def test_attempts_that_succeeded_count(tmp_path, report):
    measured = read(tmp_path, report)
    assert measured.scene_s.tolist() == [10.0, 30.0]
    assert measured.total_s == 130.0


def test_more_scenes_are_drawn_from_those_measured(tmp_path, report):
    measured = read(tmp_path, report)
    assert measured.drawn(None, 1).tolist() == [10.0, 30.0]
    drawn = measured.drawn(1000, 1)
    assert set(drawn.tolist()) == {10.0, 30.0}
    np.testing.assert_array_equal(drawn, measured.drawn(1000, 1))
    assert not np.array_equal(drawn, measured.drawn(1000, 2))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda report: report.pop("totals"),
        lambda report: report.update(format=2),
        lambda report: report.update(scenes=[scene("b", "failed", 5.0)]),
        lambda report: report.update(scenes=[scene("b", "done")]),
        lambda report: report.update(scenes=3),
    ],
)
def test_what_is_no_report_of_a_batch_is_refused(tmp_path, report, spoil):
    spoil(report)
    with pytest.raises(BadInput, match=r"report\.json"):
        read(tmp_path, report)
