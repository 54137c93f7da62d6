"""COLMAP's images.txt: two lines an image, `id qw qx qy qz tx ty tz camera name`, camera_from_world, and its features.

Source: https://colmap.github.io/format.html
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from data_tools.trajectory_files.named_images import NamedPose
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import read_lines

KIND = "COLMAP, by names of images"
_LONGEST_ERROR = 0.01  # of a quaternion's length
_WORDS = 10


def is_image_line(line: str) -> bool:
    """Whether a line reads like the first one of an image."""
    words = line.split(maxsplit=_WORDS - 1)
    return len(words) == _WORDS and _whole(words[0]) and _whole(words[8]) and all(map(_number, words[1:8]))


def read_colmap_images(path: Path) -> list[NamedPose]:
    """The images of a file with their poses; raises BadInput naming the line."""
    images, lines = [], iter(enumerate(read_lines(path), 1))
    for number, line in lines:
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if not is_image_line(line):
            form = "`id qw qx qy qz tx ty tz camera name`"
            raise BadInput(f"{path}, line {number}: expected {form}, got '{line[:40]}'")
        *words, name = line.split(maxsplit=_WORDS - 1)
        images.append(NamedPose(name.strip(), _world_from_camera(np.array(words[1:8], dtype=np.float64))))
        _, features = next(lines, (0, ""))
        if is_image_line(features) and not _number(features.split()[-1]):
            raise BadInput(f"{path}, line {number + 1}: each image has two lines, the second of which may be empty")
    return images


def _world_from_camera(numbers: Float64Array) -> Float64Array:
    """The pose that qw qx qy qz tx ty tz, (7,) of camera_from_world, mean; not finite where they mean none."""
    norm, pose = float(np.linalg.norm(numbers[:4])), np.eye(4)
    if not abs(norm - 1) <= _LONGEST_ERROR:  # also refuses nan
        return np.full((4, 4), np.nan)
    pose[:3, :3] = Rotation.from_quat(numbers[[1, 2, 3, 0]]).as_matrix().T
    pose[:3, 3] = -pose[:3, :3] @ numbers[4:]
    return pose


def _whole(word: str) -> bool:
    return word.removeprefix("-").isdecimal()


def _number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
