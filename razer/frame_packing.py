"""A fused frame in some fifty kilobytes: what is needed to fuse it and cast its votes once more.

Kept are the readings the map looked at (`ObservedSurface`, every `stride`-th pixel): they lie closer than voxels do
at the farthest depth, so that pixels left out bring no voxel more. Depth is coded as inverse depth, in which the
error of stereo and structured-light sensors is even, and then losslessly; differences of neighbours are small numbers
whose high bytes are mostly zero. Colour is a JPEG.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from itertools import accumulate, pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.cells import ObservedSurface
from razer.frame import Frame, Intrinsics

INVERSE_DEPTH_STEP = 0.0005  # 1/m: the error is at most 0.00025 z^2, a tenth of a Kinect's own step
JPEG_QUALITY = 90
_HEADER = struct.Struct("<4d5I")

Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Replay:
    """A frame as it was kept: its strided images without a pose, and ids (h, w) int32, the track at each pixel."""

    frame: Frame
    ids: Ints


def pack(frame: Frame, surface: ObservedSurface, ids: Ints) -> bytes:
    """The frame with the surface seen in it and the strided id image (h, w) of its votes."""
    height, width = surface.depth.shape
    stride, matrix = surface.stride, surface.matrix
    bgr = cv2.cvtColor(np.ascontiguousarray(frame.rgb[::stride, ::stride]), cv2.COLOR_RGB2BGR)
    color = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    parts = (color, _squeezed(_inverse_depth(surface.depth)), _deflated(ids.view(np.uint8).reshape(-1, 4)))
    header = _HEADER.pack(
        matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], width, height, *(len(part) for part in parts)
    )
    return b"".join((header, *parts))


def unpack(packed: bytes, frame_index: int) -> Replay:
    """What `pack` packed, with depth within 0.00025 z^2 metres."""
    fx, fy, cx, cy, width, height, *lengths = _HEADER.unpack_from(packed)
    borders = accumulate(lengths, initial=_HEADER.size)
    color, depth, ids = (packed[start:end] for start, end in pairwise(borders))
    shape = (height, width)
    rgb = cv2.cvtColor(cv2.imdecode(np.frombuffer(color, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    frame = Frame(
        index=frame_index,
        stamp=0.0,
        rgb=rgb.astype(np.uint8, copy=False),
        depth=_depth_m(_unsqueezed(depth, shape)),
        intrinsics=Intrinsics(width, height, fx, fy, cx, cy),
    )
    return Replay(frame, np.ascontiguousarray(_inflated(ids, 4)).view(np.int32).reshape(shape))


def _inverse_depth(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    with np.errstate(divide="ignore"):
        steps = np.rint(np.float32(1 / INVERSE_DEPTH_STEP) / depth)
    return np.where(depth > 0, np.clip(steps, 1, 65535), 0).astype(np.uint16)


def _depth_m(steps: NDArray[np.uint16]) -> NDArray[np.float32]:
    return np.where(steps > 0, np.float32(1 / INVERSE_DEPTH_STEP) / np.maximum(steps, 1), 0).astype(np.float32)


def _squeezed(image: NDArray[np.uint16]) -> bytes:
    """Differences of neighbours, small ones of either sign as small numbers."""
    difference = np.diff(image.ravel(), prepend=np.uint16(0)).view(np.int16)
    return _deflated(((difference << 1) ^ (difference >> 15)).view(np.uint8).reshape(-1, 2))


def _unsqueezed(packed: bytes, shape: tuple[int, int]) -> NDArray[np.uint16]:
    folded = np.ascontiguousarray(_inflated(packed, 2)).view(np.uint16)
    difference = (folded >> 1) ^ -(folded & 1)
    return np.cumsum(difference, dtype=np.uint16).reshape(shape)


def _deflated(rows: NDArray[np.uint8]) -> bytes:
    """The bytes of (N, B), first all the lowest ones, then the next: runs, which are quick to find."""
    squeezer = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_RLE)
    return squeezer.compress(rows.T.tobytes()) + squeezer.flush()


def _inflated(packed: bytes, n_bytes: int) -> NDArray[np.uint8]:
    return np.frombuffer(zlib.decompress(packed), np.uint8).reshape(n_bytes, -1).T
