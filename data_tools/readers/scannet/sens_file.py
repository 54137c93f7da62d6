"""The .sens file format of ScanNet, version 4: one header, then frame after frame, then inertial measurements.

Little-endian; matrices are 16 floats row by row. Header: version (u32), length of name (u64) and name, intrinsic and
extrinsic matrix of colour and then of depth, kinds of compression of colour and depth (i32), width and height of
colour and then of depth (u32), depth units a metre (f32), number of frames (u64). Frame: world_from_camera of the
depth camera (-inf = unknown), stamps of colour and depth in microseconds, bytes of colour and depth (u64 each), and
both images. Source: https://github.com/ScanNet/ScanNet/blob/master/SensReader/src/sensorData.h
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.camera import MIN_DEPTH_SCALE
from data_tools.recordings.rgbd_alignment import Size
from razer.arrays import Float64Array, Int64Array
from razer.errors import BadInput
from razer.files import opened

VERSION = 4
COLOR_KINDS = {0: "raw", 1: "png", 2: "jpeg"}
DEPTH_KINDS = {0: "raw_ushort", 1: "zlib_ushort", 2: "occi_ushort"}
NAME = struct.Struct("<IQ")
BODY = struct.Struct("<64f2i4IfQ")
FRAME_HEAD = np.dtype([("pose", "<f4", (4, 4)), ("color_us", "<u8"), ("depth_us", "<u8"), ("sizes", "<u8", 2)])
_LONGEST_NAME = 4096
_LARGEST_SIDE = 2**14  # pixels


@dataclass(frozen=True, slots=True)
class SensHeader:
    """What a file says of all its frames; matrices (4, 4); color_kind and depth_kind are values of COLOR_KINDS and
    DEPTH_KINDS; sizes (width, height); frames begin at byte `start`."""

    color_matrix: Float64Array
    color_extrinsic: Float64Array
    depth_matrix: Float64Array
    depth_extrinsic: Float64Array
    color_kind: str
    depth_kind: str
    color_size: Size
    depth_size: Size
    depth_shift: float
    n_frames: int
    start: int


@dataclass(frozen=True, slots=True)
class SensIndex:
    """Where the frames are that are wholly there: heads (F,) of FRAME_HEAD, offsets (F,) of their images in bytes;
    cut says in words what is missing, empty = nothing."""

    heads: NDArray[np.void]
    offsets: Int64Array
    cut: str


def read_header(path: Path) -> SensHeader:
    """The header of a file; raises BadInput naming it where it is no .sens of version 4, or ends within it."""
    try:
        with opened(path) as file:
            version, length = NAME.unpack(_exactly(file, NAME.size))
            if version != VERSION or length > _LONGEST_NAME:
                raise BadInput(f"{path} is no .sens file of version {VERSION} (it begins with {version})")
            file.seek(length, 1)
            body = BODY.unpack(_exactly(file, BODY.size))
            return _header(path, body, file.tell())
    except EOFError:
        raise BadInput(f"{path} ends within its header: copy or download it again") from None


def read_index(path: Path, header: SensHeader) -> SensIndex:
    """The places of all frames, by reading their heads alone; what comes after a frame that is cut off or damaged
    cannot be found and is left out."""
    heads: list[np.void] = []
    offsets: list[int] = []
    at = header.start
    with opened(path) as file:
        end = file.seek(0, 2)
        while len(heads) < header.n_frames:
            file.seek(at)
            data = file.read(FRAME_HEAD.itemsize)
            if len(data) < FRAME_HEAD.itemsize:
                break
            head = np.frombuffer(data, FRAME_HEAD)[0]
            after = at + FRAME_HEAD.itemsize + sum(head["sizes"].tolist())
            if after > end:
                break
            heads.append(head)
            offsets.append(at + FRAME_HEAD.itemsize)
            at = after
    missing = len(heads) < header.n_frames
    cut = f"{path.name} is cut short: {len(heads)} of {header.n_frames} frames are there" if missing else ""
    return SensIndex(np.array(heads, FRAME_HEAD), np.array(offsets, np.int64), cut)


def _header(path: Path, body: tuple[float, ...], start: int) -> SensHeader:
    matrices = np.array(body[:64], np.float64).reshape(4, 4, 4)
    color_kind, depth_kind, *sizes = (int(number) for number in body[64:70])
    shift, n_frames = body[70], int(body[71])
    if (
        color_kind not in COLOR_KINDS
        or depth_kind not in DEPTH_KINDS
        or not all(0 < size <= _LARGEST_SIDE for size in sizes)
        or not MIN_DEPTH_SCALE <= shift < np.inf
    ):
        raise BadInput(f"{path} is damaged: its header names no known compression, image size or depth scale")
    if DEPTH_KINDS[depth_kind] == "occi_ushort":
        raise BadInput(f"{path} has depth in the closed occi_ushort code: export it with the sensor's own tools")
    return SensHeader(
        matrices[0],
        matrices[1],
        matrices[2],
        matrices[3],
        COLOR_KINDS[color_kind],
        DEPTH_KINDS[depth_kind],
        (sizes[0], sizes[1]),
        (sizes[2], sizes[3]),
        shift,
        n_frames,
        start,
    )


def _exactly(file: BinaryIO, count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise EOFError
    return data
