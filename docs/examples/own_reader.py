"""A reader of your own: a function that returns anything with the attributes of a sequence."""

import sys
from pathlib import Path

import cv2
import numpy as np

import razer
from data_tools import open_sequence


class Numbered:
    """Files rgb_0.png, depth_0.png (millimetres), rgb_1.png, ... without poses."""

    name, has_poses, depth_scale = "numbered", False, 1000.0
    intrinsics = razer.Intrinsics(160, 120, fx=140, fy=140, cx=79.5, cy=59.5)

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __len__(self) -> int:
        return len(list(self.folder.glob("rgb_*.png")))

    def __getitem__(self, index: int) -> razer.Frame:
        if index >= len(self):
            raise IndexError(index)
        rgb = cv2.imread(str(self.folder / f"rgb_{index}.png"))[..., ::-1]
        depth = cv2.imread(str(self.folder / f"depth_{index}.png"), cv2.IMREAD_UNCHANGED) / np.float32(1000)
        return razer.Frame(index, index / 30, np.ascontiguousarray(rgb), depth, self.intrinsics)


sequence = open_sequence(sys.argv[1], reader=lambda folder, declared, use_poses: Numbered(folder))
print(len(sequence), "frames of", sequence.intrinsics.width, "x", sequence.intrinsics.height)
