"""The project's own layout, and plain folders of images."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from data_tools.registry import open_sequence
from razer.errors import BadInput, UnusableFrame
from tests.support.recordings import HEIGHT, WIDTH, camera_json, colour, depth, write_folder, write_image


def test_own_folder_with_everything(tmp_path: Path) -> None:
    write_folder(tmp_path, camera=camera_json(depth_scale=500.0))
    (tmp_path / "stamps.txt").write_text("10\n10.5\n11\n")
    (tmp_path / "trajectory.txt").write_text("10.0004 1 0 0 0 0 0 1\n11 3 0 0 0 0 0 1\n")
    ids = np.zeros((HEIGHT, WIDTH), np.uint16)
    ids[2, 3] = 40000
    for i in range(3):
        write_image(tmp_path / "ids" / f"{i:06d}.png", ids)
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "objects.json").write_text(json.dumps([{"id": 40000, "class": "cup", "size": 1}]))
    sequence = open_sequence(tmp_path)
    frame = sequence[0]
    assert (frame.stamp, frame.pose[0, 3], frame.depth[0, 0]) == (10, 1, 4)
    assert frame.instance_ids is not None
    assert frame.instance_ids.dtype == np.int32
    np.testing.assert_array_equal(np.argwhere(frame.instance_ids), [[2, 3]])
    assert (frame.instance_ids[2, 3], frame.instance_classes) == (40000, {40000: "cup"})
    with pytest.raises(UnusableFrame, match=r"trajectory\.txt has no pose at 10\.5"):
        sequence[1]
    assert sequence[2].pose[0, 3] == 3


def test_a_plain_folder_needs_only_intrinsics(tmp_path: Path) -> None:
    write_folder(tmp_path)
    with pytest.raises(BadInput, match="--intrinsics"):
        open_sequence(tmp_path)
    sequence = open_sequence(tmp_path, camera="10,11,3.5,2.5", depth_scale=2000)
    assert (sequence.has_poses, sequence.depth_scale, sequence.intrinsics.fy) == (False, 2000, 11)
    assert sequence[1].depth[0, 0] == np.float32(2001 / 2000)


def test_a_frame_lost_from_a_folder_does_not_shift_the_others(tmp_path: Path) -> None:
    write_folder(tmp_path, camera=camera_json())
    (tmp_path / "trajectory.txt").write_text("".join(f"{i / 30} {i} 0 0 0 0 0 1\n" for i in range(3)))
    (tmp_path / "color" / "000000.png").unlink()
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"color/000000.* is missing"):
        sequence[0]
    (tmp_path / "depth" / "000000.png").unlink()
    frame = open_sequence(tmp_path)[0]
    assert (frame.rgb[0, 0, 0], frame.pose[0, 3]) == (1, 1)


def test_a_folder_with_matrices_and_other_names(tmp_path: Path) -> None:
    for i in (9, 10):
        write_image(tmp_path / "rgb" / f"color_{i}.png", colour(i))
        write_image(tmp_path / "depth" / f"depth_{i:04d}.png", depth(100 * i))
        (tmp_path / "pose").mkdir(exist_ok=True)
        pose = np.eye(4)
        pose[1, 3] = i
        np.savetxt(tmp_path / "pose" / f"{i}.txt", pose)
    sequence = open_sequence(tmp_path, camera="10,10,3.5,2.5")
    found = [
        (frame.rgb[0, 0, 0], float(frame.depth[0, 0]), frame.pose[1, 3]) for frame in map(sequence.__getitem__, (0, 1))
    ]
    assert found == [(9, np.float32(0.9), 9), (10, np.float32(1.0), 10)]
