"""Layouts are recognised; a folder that cannot be used is one plain line."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput
from razer.plugins import FULL_TRUST
from tests.support.recordings import camera_json, write_folder, write_seven_scenes, write_tum


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def test_layouts_are_recognised_and_reader_overrides(tmp_path: Path) -> None:
    scenes = write_seven_scenes(tmp_path / "a")
    tum = write_tum(tmp_path / "b", [1.0], [1.0])
    own = write_folder(tmp_path / "c", camera=camera_json())
    assert [recognise(folder) for folder in (scenes, tum, own)] == ["7scenes", "tum", "folder"]
    assert open_sequence(tum, reader="folder", camera="10,10,3.5,2.5").depth_scale == 1000
    assert open_sequence(own, reader="data_tools.readers.folder:read_folder", trust=FULL_TRUST).name == "c"


def _missing(folder: Path) -> dict:
    return {"folder": folder / "nowhere"}


def _empty(folder: Path) -> dict:
    return {"folder": folder}


def _unknown(folder: Path) -> dict:
    write_seven_scenes(folder / "seq-01")
    return {"folder": folder}


def _no_intrinsics(folder: Path) -> dict:
    return {"folder": write_seven_scenes(folder, intrinsics=False)}


def _all_broken(folder: Path) -> dict:
    write_seven_scenes(folder, frames=2)
    for path in folder.glob("*.depth.png"):
        truncate(path)
    return {"folder": folder}


def _wrong_list(folder: Path) -> dict:
    write_tum(folder, [1.0], [1.0])
    (folder / "depth.txt").write_text("one depth/0.png\n")
    return {"folder": folder}


def _broken_json(folder: Path) -> dict:
    write_folder(folder, camera=camera_json())
    (folder / "intrinsics.json").write_text('{"width": 8}')
    return {"folder": folder}


FOLDER_FAULTS = {
    "missing folder": (_missing, "nowhere does not exist"),
    "empty folder": (_empty, "is empty"),
    "one level too high": (_unknown, "no known layout.*seq-01"),
    "no intrinsics": (_no_intrinsics, "--intrinsics fx,fy,cx,cy"),
    "all frames broken": (_all_broken, r"no usable frame.*depth\.png is truncated"),
    "list without stamps": (_wrong_list, r"depth\.txt, line 1"),
    "broken intrinsics.json": (_broken_json, r"intrinsics\.json must be JSON"),
    "unknown reader": (lambda folder: {"folder": folder, "reader": "rosbag"}, "unknown reader 'rosbag'"),
    "wrong reader": (
        lambda folder: {"folder": write_seven_scenes(folder), "reader": "tum"},
        "has not the layout that reader 'tum' reads",
    ),
    "intrinsics of three": (lambda folder: {"folder": folder, "camera": "1,2,3"}, "'1,2,3' are not understood"),
    "negative focal length": (
        lambda folder: {"folder": folder, "camera": "-1,2,3,4"},
        "'-1,2,3,4': focal lengths must be positive.*; give --intrinsics fx",
    ),
    "no such camera file": (lambda folder: {"folder": folder, "camera": "x.json"}, "does not exist"),
    "zero depth scale": (lambda folder: {"folder": folder, "depth_scale": 0.0}, "depth scale must be positive"),
}


@pytest.mark.parametrize("fault", FOLDER_FAULTS)
def test_an_unusable_folder_is_one_plain_line(tmp_path: Path, fault: str) -> None:
    prepare, message = FOLDER_FAULTS[fault]
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(**prepare(tmp_path))
    assert "\n" not in str(caught.value)
