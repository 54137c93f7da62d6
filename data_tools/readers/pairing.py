"""Association of colour with depth images, by their names or by two lists of stamps."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from data_tools.readers.tum import MAX_DIFFERENCE_S, associate
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import read_numbers

FRAMES_PER_SECOND = 30.0
_LONGEST_NUMBER = 7  # digits of a number that counts frames
_FEWEST_FOR_A_RATE = 4  # images; of fewer, a lost one would look like another rate
_SECONDS = re.compile(r"\d+\.\d+")
# Whole numbers as long as these are times since 1970 in milli-, micro- or nanoseconds.
_UNITS_PER_S = {13: 1e3, 16: 1e6, 19: 1e9}

Images = dict[str, Path]
"""Image files by the name before the suffix."""
Stamps = dict[str, float]
"""Seconds, or numbers, by the name of the image."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A colour and a depth image, None where one is missing; key is the name or number of the frame; stamp is in
    seconds, by a clock or else counted in thirtieths."""

    key: str
    color: Path | None
    depth: Path | None
    stamp: float


def pair_images(folder: Path, color: Images, depth: Images) -> tuple[list[Pair], bool]:
    """The frames of two sets of images, and whether their stamps are those of a clock; raises BadInput.

    With stamps_color.txt and stamps_depth.txt, or with stamps as names: those within 0.02 s, closest first, and what
    finds no partner is left out, as the two may come at different rates. Else by name or number, and a missing
    partner is a frame that cannot be used; where one kind has only every n-th number, by the nearest."""
    clocks = _listed(folder, color, depth) or _named(color, depth)
    if clocks:
        pairs = _nearest(color, depth, clocks, MAX_DIFFERENCE_S)
        if not pairs:
            raise BadInput(f"{folder}: no colour image is within {MAX_DIFFERENCE_S} s of a depth image")
        return pairs, True
    if not color.keys() & depth.keys():
        color, depth = _by_number(color), _by_number(depth)
    numbers = _numbers(color), _numbers(depth)
    steps = [_step(each) for each in numbers]
    if steps[0] != steps[1]:
        pairs = _nearest(color, depth, numbers, min(steps) / 2)
        return [replace(pair, stamp=pair.stamp / FRAMES_PER_SECOND) for pair in pairs], False
    return _same_names(color, depth), False


def _same_names(color: Images, depth: Images) -> list[Pair]:
    keys = sorted(color.keys() | depth.keys(), key=lambda key: (int(key) if key.isdecimal() else 0, key))
    numbered = all(key.isdecimal() and len(key) <= _LONGEST_NUMBER for key in keys)
    stamps = [(int(key) if numbered else i) / FRAMES_PER_SECOND for i, key in enumerate(keys)]
    return [Pair(key, color.get(key), depth.get(key), stamp) for key, stamp in zip(keys, stamps, strict=True)]


def _nearest(color: Images, depth: Images, stamps: tuple[Stamps, Stamps], apart: float) -> list[Pair]:
    colors, depths = list(stamps[0]), list(stamps[1])
    matches = associate(_array(stamps[0]), _array(stamps[1]), apart)
    return [Pair(depths[d], color[colors[c]], depth[depths[d]], stamps[1][depths[d]]) for c, d in matches]


def _by_number(files: Images) -> Images:
    """The same files by the last number in their names: color_12.jpg belongs to depth_0012.png."""
    return {str(number) if (number := _last_number(stem)) is not None else stem: p for stem, p in files.items()}


def _listed(folder: Path, color: Images, depth: Images) -> tuple[Stamps, Stamps] | None:
    """The stamps of stamps_color.txt and stamps_depth.txt by name, if both are there."""
    paths = folder / "stamps_color.txt", folder / "stamps_depth.txt"
    if not all(path.is_file() for path in paths):
        return None
    first, second = (_stamps_of(path, files) for path, files in zip(paths, (color, depth), strict=True))
    return first, second


def _stamps_of(path: Path, files: Images) -> Stamps:
    names = sorted(files, key=lambda stem: (_last_number(stem) or 0, stem))
    stamps = read_numbers(path, "one number of seconds a line").tolist()
    if len(stamps) != len(names):
        raise BadInput(f"{path} has {len(stamps)} stamps for {len(names)} images: it needs one each")
    return dict(zip(names, stamps, strict=True))


def _named(color: Images, depth: Images) -> tuple[Stamps, Stamps] | None:
    """The stamps that the names of all images are, else None."""
    stamps = [{stem: stamp for stem in files if (stamp := _clock(stem)) is not None} for files in (color, depth)]
    if not (color and depth) or len(stamps[0]) < len(color) or len(stamps[1]) < len(depth):
        return None
    return stamps[0], stamps[1]


def _clock(stem: str) -> float | None:
    if _SECONDS.fullmatch(stem):
        return float(stem)
    return int(stem) / _UNITS_PER_S[len(stem)] if stem.isdecimal() and len(stem) in _UNITS_PER_S else None


def _numbers(files: Images) -> Stamps:
    return {stem: float(number) for stem in files if (number := _last_number(stem)) is not None}


def _last_number(stem: str) -> int | None:
    numbers = re.findall(r"\d+", stem)
    return int(numbers[-1]) if numbers else None


def _step(numbers: Stamps) -> float:
    return float(np.median(np.diff(np.sort(_array(numbers))))) if len(numbers) >= _FEWEST_FOR_A_RATE else 1.0


def _array(values: Stamps) -> Float64Array:
    return np.array(list(values.values()), dtype=np.float64)
