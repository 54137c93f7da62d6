"""Packed frame: an observation without its pose as bytes, a header in JSON and what it describes; checkpoints keep such
bytes in files, so reading them back must choose no code, as unpickling would."""

from __future__ import annotations

import json
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Int32Array
from razer.detection.best_views import Region
from razer.frame import Intrinsics

_LENGTH_BYTES = 4  # of the header's length, the lowest first
_BLOBS = ("color", "has_color", "depth", "pixels", "embeddings", "leftover_masks", "leftover_pixels")
Properties = tuple[int, int, float, float, str | None, Region | None, bool]


@dataclass(frozen=True)
class PackedFrame:
    """An observation without its pose.

    `pixels` are the detections' readings as pixels of the strided images, and `properties` what else is known of each
    detection: mask, number of readings, score, quality, class name, region, whether it is stuff; `embeddings` (N, D)
    are theirs. `has_color` are packed bits, None = all true. `leftover_masks` (M,) and `leftover_pixels` (M,) are what
    masks hold besides their detections, a pixel in each cell.
    """

    index: int
    stamp: float
    intrinsics: Intrinsics
    color: bytes
    has_color: bytes | None
    depth: bytes
    pixels: bytes
    properties: list[Properties]
    embeddings: NDArray[np.int8]
    leftover_masks: Int32Array
    leftover_pixels: Int32Array

    def to_bytes(self) -> bytes:
        """The same as bytes."""
        blobs = {
            "color": self.color,
            "has_color": self.has_color or b"",
            "depth": self.depth,
            "pixels": self.pixels,
            "embeddings": self.embeddings.tobytes(),
            "leftover_masks": self.leftover_masks.astype(np.int32).tobytes(),
            "leftover_pixels": self.leftover_pixels.astype(np.int32).tobytes(),
        }
        header = {
            "index": self.index,
            "stamp": self.stamp,
            "intrinsics": astuple(self.intrinsics),
            "properties": [_listed(*each) for each in self.properties],
            "dimension": self.embeddings.shape[1],
            "lengths": [len(blobs[name]) for name in _BLOBS],
        }
        text = json.dumps(header).encode()
        return b"".join([len(text).to_bytes(_LENGTH_BYTES, "little"), text, *(blobs[name] for name in _BLOBS)])

    @classmethod
    def from_bytes(cls, data: bytes) -> PackedFrame:
        """What `to_bytes` made; raises ValueError, KeyError or TypeError for anything else."""
        start = _LENGTH_BYTES + int.from_bytes(data[:_LENGTH_BYTES], "little")
        header = json.loads(data[_LENGTH_BYTES:start])
        blobs: dict[str, bytes] = {}
        for name, length in zip(_BLOBS, header["lengths"], strict=True):
            blobs[name] = data[start : start + length]
            start += length
        return cls(
            index=header["index"],
            stamp=header["stamp"],
            intrinsics=Intrinsics(*header["intrinsics"]),
            color=blobs["color"],
            has_color=blobs["has_color"] or None,
            depth=blobs["depth"],
            pixels=blobs["pixels"],
            properties=[_unlisted(*each) for each in header["properties"]],
            embeddings=np.frombuffer(blobs["embeddings"], np.int8).reshape(-1, header["dimension"]),
            leftover_masks=np.frombuffer(blobs["leftover_masks"], np.int32),
            leftover_pixels=np.frombuffer(blobs["leftover_pixels"], np.int32),
        )


def _listed(*properties: Any) -> list[Any]:
    *first, region, is_stuff = properties
    numbers = [int(first[0]), int(first[1]), float(first[2]), float(first[3]), first[4]]
    return [*numbers, None if region is None else astuple(region), bool(is_stuff)]


def _unlisted(*listed: Any) -> Properties:
    mask, length, score, quality, class_name, region, is_stuff = listed
    if region is not None:
        box, pixels, whole = region
        region = Region(tuple(box), pixels, whole)
    return mask, length, score, quality, class_name, region, is_stuff
