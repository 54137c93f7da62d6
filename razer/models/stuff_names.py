"""Which class names are stuff: surfaces that are not counted, by a list of words and by what a user says."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Sequence

import numpy as np

from razer.arrays import BoolArray
from razer.errors import BadInput

# Of the stuff of ADE20K, COCO-Stuff, NYU40 and ScanNet what is a surface or outdoors; what they call stuff and a room
# has several of (cabinet, curtain, door, mirror, rug, shelf, table, window) is counted.
_STUFF = """
wall floor flooring ceiling roof carpet building house skyscraper sky cloud fog tree bush grass field playingfield
earth ground land dirt mud sand gravel snow rock mountain hill road street sidewalk pavement path runway railroad
water sea river lake waterfall
"""
# Words that leave it what it is: COCO-Stuff's wall-brick and floor-other-merged, a tiled floor, a wood ceiling.
_OF_A_KIND = """
brick carpeted concrete exterior hardwood interior marble merged other panel plaster stone stuff tile tiled track wood
wooden
"""
STUFF = frozenset(_STUFF.split())
_KINDS = frozenset(_OF_A_KIND.split())


def is_stuff_name(name: str) -> bool:
    """Whether a class name means stuff: only words of STUFF, and such that say of what kind it is; of synonyms
    ("floor;flooring", "road, route") the first counts."""
    words = [_singular(word) for word in re.findall(r"[a-z]+", re.split(r"[,;]", name.lower())[0])]
    return any(word in STUFF for word in words) and all(word in STUFF or word in _KINDS for word in words)


def stuff_classes(class_names: Sequence[str], chosen: str | Collection[str] | None = None) -> BoolArray:
    """Which of C class names are stuff (C,): the chosen ones, a list or a text with commas; None = by `is_stuff_name`.
    Raises BadInput for a choice that is no class."""
    if chosen is None:
        return np.array([is_stuff_name(name) for name in class_names], np.bool_)
    names = listed_names(chosen)
    for name in names:
        if name not in class_names:
            close = ", ".join(difflib.get_close_matches(name, class_names, n=3, cutoff=0)) or "none"
            raise BadInput(
                f"segmenter option stuff names '{name}', which the model does not know; the nearest: {close}"
            )
    return np.array([name in names for name in class_names], np.bool_)


def listed_names(names: str | Collection[str]) -> tuple[str, ...]:
    """The names of a list, or of a text with commas; raises BadInput for anything else."""
    parts = names.split(",") if isinstance(names, str) else names
    if not isinstance(parts, list | tuple | set | frozenset) or not all(isinstance(part, str) for part in parts):
        raise BadInput(f"{names!r} is no list of names: write them with commas, as in wall,floor")
    return tuple(part.strip() for part in parts if part.strip())


def _singular(word: str) -> str:
    return word[:-1] if word.endswith("s") and word[:-1] in STUFF else word
