"""Annotated instances of ScanNet's frames: instance-filt/0.png or the zip it comes in, and the names of objects.

A pixel of the colour image holds the number of the object it shows, counted from 1: objectId of the aggregation + 1;
0 is nobody's. The filtered images (instance-filt) go before the plain ones (instance). Source:
https://github.com/ScanNet/ScanNet, "2D annotation projections"
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from data_tools.recordings.images import decode, read_member, unusable_frame
from data_tools.truth.label_map import find_label_map
from data_tools.truth.scannet_truth import OBJECTS, read_objects
from razer.arrays import Uint16Array
from razer.errors import BadInput, UnusableFrame
from razer.files import Archive
from razer.vocabulary import vocabulary

_FOLDERS = ("instance-filt", "instance")
_CLASSES = "scannet200"
_LONGEST_NUMBER = 9  # digits


@dataclass(frozen=True)
class InstanceImages:
    """The image of each frame: the folder or archive they are in, and their names there, None where one is missing."""

    place: Path
    names: tuple[str | None, ...]

    def __call__(self, index: int) -> Uint16Array | None:
        """(H, W) of a frame on the grid of colour, 0 = nobody's; None where there is none; raises UnusableFrame."""
        name = self.names[index]
        if name is None:
            return None
        ids = decode(self._data(name), self.label(index), cv2.IMREAD_UNCHANGED)
        if ids.ndim != 2 or ids.dtype not in (np.uint8, np.uint16):
            raise UnusableFrame(f"{self.label(index)} is not a grey image of 8 or 16 bits with one id a pixel")
        return ids.astype(np.uint16)

    def label(self, index: int) -> str:
        """What messages call an image."""
        return f"{self.place.name}/{self.names[index]}"

    def _data(self, name: str) -> bytes:
        with unusable_frame():
            if self.place.is_dir():
                return read_member(self.place / name)
            return _archive(self.place, os.getpid()).read(name)


def find_instance_images(places: Sequence[Path], scene: str, numbers: Sequence[int]) -> InstanceImages | None:
    """The images of the frames with these numbers, in the first of some folders that has any; None where none has."""
    for kind in _FOLDERS:
        for place in places:
            for source in (place / kind, place / f"{scene}_2d-{kind}.zip", place / f"{kind}.zip"):
                name_of = _numbered(source)
                names = tuple(name_of.get(number) for number in numbers)
                if any(names):
                    return InstanceImages(source, names)
    return None


def object_names(folder: Path, scene: str) -> Mapping[int, str]:
    """The name of each object by the number it has in the images: that of its class in ScanNet200 where the label map
    is in the folder or above it and has one, else the annotator's; none without an aggregation. Raises BadInput for one
    that is damaged."""
    files = (folder / f"{scene}{OBJECTS}", folder / f"{scene}_vh_clean{OBJECTS}", *sorted(folder.glob(f"*{OBJECTS}")))
    path = next((file for file in files if file.is_file()), None)
    if path is None:
        return {}
    label_map, classes = find_label_map(folder), vocabulary(_CLASSES)
    names = {}
    for each in read_objects(path):
        known = label_map is not None and each.label in label_map.rows
        category = label_map.category(each.label, classes) if label_map is not None and known else None
        names[each.number + 1] = category.name if category else each.label
    return names


def _numbered(source: Path) -> dict[int, str]:
    """The images in a folder or an archive by the number of their frame."""
    if source.is_dir():
        names = [path.name for path in source.iterdir()]
    elif source.is_file():
        try:
            names = list(_archive(source, os.getpid()).names)
        except BadInput:
            return {}
    else:
        return {}
    paths = [Path(name) for name in names if name.endswith(".png")]
    return {
        int(path.stem): path.as_posix() for path in paths if path.stem.isdecimal() and len(path.stem) <= _LONGEST_NUMBER
    }


@lru_cache(maxsize=4)
def _archive(path: Path, process: int) -> Archive:
    """An archive opened once in each process, as those that share a file share the place where they read it."""
    return Archive(path)
