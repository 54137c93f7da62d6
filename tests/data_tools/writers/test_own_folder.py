"""The project's own layout, written and read again."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame


def test_folder_round_trip(tmp_path: Path) -> None:
    room = SyntheticRoom(0, n_frames=3, width=64, height=48)
    assert write_folder(room, tmp_path / "room", lossless=True) == []
    back = open_sequence(tmp_path / "room")
    assert len(back) == 3
    assert back.has_poses
    for index in range(3):
        one, other = room[index], back[index]
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.instance_ids, other.instance_ids)
        assert np.array_equal(one.part_ids, other.part_ids)
        assert other.part_ids.dtype == np.uint8
        np.testing.assert_allclose(one.depth, other.depth, atol=0.00051)
        np.testing.assert_allclose(one.pose, other.pose, atol=1e-7)
        assert one.stamp == pytest.approx(other.stamp, abs=1e-6)
        assert {k: one.instance_classes[k] for k in np.unique(one.instance_ids)} == {
            k: other.instance_classes[k] for k in np.unique(one.instance_ids)
        }
    assert back.intrinsics == room.intrinsics


def test_jpeg_is_close_and_an_existing_folder_is_left_alone(tmp_path: Path) -> None:
    room = SyntheticRoom(0, n_frames=1, width=160, height=120)
    write_folder(room, tmp_path / "room")
    assert [path.name for path in tmp_path.iterdir()] == ["room"]
    difference = open_sequence(tmp_path / "room")[0].rgb.astype(int) - room[0].rgb
    assert np.abs(difference).mean() < 4
    with pytest.raises(BadInput, match="exists"):
        write_folder(room, tmp_path / "room")


def test_unusable_frames_are_left_out_and_named(tmp_path: Path) -> None:
    class Broken(SyntheticRoom):
        def __getitem__(self, index: int) -> Frame:
            if index == 1:
                raise UnusableFrame("a broken image")
            return super().__getitem__(index)

    room = Broken(0, n_frames=3, width=32, height=24)
    assert write_folder(room, tmp_path / "room", lossless=True) == [(1, "a broken image")]
    back = open_sequence(tmp_path / "room")
    assert len(back) == 2
    assert np.array_equal(back[1].rgb, room[2].rgb)
    np.testing.assert_allclose(back[1].pose, room[2].pose, atol=1e-7)


def test_a_recording_from_before_parts_were_kept_opens_without_them(tmp_path: Path) -> None:
    room = SyntheticRoom(0, n_frames=2, width=64, height=48)
    write_folder(room, tmp_path / "room")
    shutil.rmtree(tmp_path / "room" / "parts")
    frame = open_sequence(tmp_path / "room")[1]
    assert frame.part_ids is None
    assert np.array_equal(frame.instance_ids, room[1].instance_ids)


def test_a_damaged_image_of_parts_is_named(tmp_path: Path) -> None:
    write_folder(SyntheticRoom(0, n_frames=2, width=64, height=48), tmp_path / "room")
    file = tmp_path / "room" / "parts" / "000001.png"
    shutil.copy(tmp_path / "room" / "ids" / "000001.png", file)
    with pytest.raises(UnusableFrame, match=r"parts/000001.png .*must be an 8-bit PNG"):
        open_sequence(tmp_path / "room")[1]
