"""Calibration files: what is written is read, and what is no calibration is named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from data_tools.recordings.rgbd_calibration import RgbdCalibration, read_rgbd_calibration
from razer.errors import BadInput
from razer.frame import Intrinsics

CALIBRATION = RgbdCalibration(Intrinsics(640, 480, 529.1, 530.0, 322.0, 236.5), np.eye(4))


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(CALIBRATION.to_json() | {"rgbd": None}))
    read = read_rgbd_calibration(path)
    assert read.color == CALIBRATION.color
    np.testing.assert_array_equal(read.color_from_depth, CALIBRATION.color_from_depth)


@pytest.mark.parametrize(
    "change",
    [
        {"color": None},
        {"color": {"width": 640}},
        {"color_from_depth": [[1, 0], [0, 1]]},
        {"color_from_depth": (2 * np.eye(4)).tolist()},
        {"color_from_depth": "nonsense"},
        {"color_from_depth": [[1, 0, 0, -30.0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},  # millimetres
        {"color": {"width": 640, "height": 480, "fx": "wide", "fy": 1, "cx": 1, "cy": 1}},
    ],
)
def test_what_is_no_calibration_is_named(change: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(CALIBRATION.to_json() | change))
    with pytest.raises(BadInput, match=r"calibration\.json"):
        read_rgbd_calibration(path)


def test_a_missing_file_and_a_broken_one_are_named(tmp_path: Path) -> None:
    (tmp_path / "broken.json").write_text("{")
    for name in ("missing.json", "broken.json"):
        with pytest.raises(BadInput, match=name):
            read_rgbd_calibration(tmp_path / name)
