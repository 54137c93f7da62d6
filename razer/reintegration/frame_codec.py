"""Compression of observations: all that is needed to map a frame once more, at another pose, in some fifty kilobytes.

Kept are the depth readings that the map used (`ObservedSurface`, every `stride`-th pixel): they lie closer than voxels
do at the farthest depth, so that pixels left out bring no voxel more. Depth is coded as inverse depth, in which the
error of stereo and structured-light sensors is even, and then losslessly; differences of neighbours are small numbers
whose high bytes are mostly zero. Colour is a JPEG. Of a detection its readings are kept, and not their positions in the
world.
"""

from __future__ import annotations

import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array, Uint8Array, Uint16Array
from razer.config import LiftingSettings, VoxelSettings
from razer.detection.detection_parts import fit_box
from razer.detection.lifting import Detection, Lifted, occupied_cells
from razer.detection.observed_surface import ObservedSurface
from razer.detection.perception import Observation
from razer.detection.view_sector import view_sector
from razer.frame import Frame, Intrinsics
from razer.reintegration.packed_frame import PackedFrame

INVERSE_DEPTH_STEP = 0.0005  # 1/m: the error is at most 0.00025 z^2, a tenth of a Kinect's own step
JPEG_QUALITY = 90
DEFAULT_LIFTING = LiftingSettings()


def pack(observation: Observation) -> bytes:
    """Compress an observation, but for its pose."""
    frame, surface, detections = observation.frame, observation.surface, observation.lifted.detections
    height, width = surface.depth.shape
    stride, matrix = surface.stride, surface.matrix
    bgr = cv2.cvtColor(np.ascontiguousarray(frame.rgb[::stride, ::stride]), cv2.COLOR_RGB2BGR)
    pixel = surface.rows * width + surface.columns
    pixels = pixel[np.concatenate([np.zeros(0, np.int32), *(d.pixels for d in detections)])]
    leftover_masks, leftover_readings = _leftovers(surface, observation.lifted)
    packed = PackedFrame(
        index=frame.index,
        stamp=frame.stamp,
        intrinsics=Intrinsics(width, height, matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]),
        color=cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes(),
        has_color=None if frame.has_color is None else _packed_bits(frame.has_color[::stride, ::stride]),
        depth=_delta_coded(_inverse_depth(surface.depth)),
        pixels=_deflated(np.diff(pixels, prepend=np.int32(0)).view(np.uint8).reshape(-1, 4)),
        properties=[
            (d.mask, len(d.pixels), d.score, d.quality, d.class_name, d.region, d.is_stuff) for d in detections
        ],
        embeddings=_quantized([d.embedding for d in detections]),
        leftover_masks=leftover_masks,
        leftover_pixels=pixel[leftover_readings],
    )
    return packed.to_bytes()


def _leftovers(surface: ObservedSurface, lifted: Lifted) -> tuple[Int32Array, Int32Array]:
    """The pairs of a mask and a cell that are in no detection: masks (M,), and a reading (M,) for each cell."""
    n_cells = len(surface.cells)
    member = lifted.member_mask.astype(np.int64) * n_cells + lifted.member_cell
    in_detection = np.concatenate([np.zeros(0, np.int64), *(d.mask * n_cells + d.cells for d in lifted.detections)])
    is_left = ~np.isin(member, in_detection)
    reading = np.zeros(n_cells, np.int32)
    reading[surface.pixel_cell] = np.arange(len(surface.pixel_cell), dtype=np.int32)
    return lifted.member_mask[is_left], reading[lifted.member_cell[is_left]]


def unpack(
    packed_at: tuple[bytes, Float64Array], settings: VoxelSettings, lifting: LiftingSettings = DEFAULT_LIFTING
) -> Observation:
    """The observation that `pack` compressed, at a pose (4, 4); depth is within 0.00025 z^2 metres, embeddings within
    half a degree. The frame is the strided one."""
    packed, world_from_camera = packed_at
    kept = PackedFrame.from_bytes(packed)
    shape = (kept.intrinsics.height, kept.intrinsics.width)
    rgb = cv2.cvtColor(cv2.imdecode(np.frombuffer(kept.color, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    depth = _depth_m(_delta_decoded(kept.depth, shape))
    # Not one reading may be rounded out of range, as detections count them.
    depth = np.where(depth > 0, depth.clip(settings.depth_min_m, settings.depth_max_m), np.float32(0))
    frame = Frame(
        index=kept.index,
        stamp=kept.stamp,
        rgb=rgb.astype(np.uint8, copy=False),
        depth=depth.astype(np.float32, copy=False),
        intrinsics=kept.intrinsics,
        world_from_camera=world_from_camera,
        has_color=None if kept.has_color is None else _unpacked_bits(kept.has_color, shape),
    )
    surface = ObservedSurface.of(frame, settings.voxel_size_m, settings.depth_min_m, settings.depth_max_m)
    return Observation(frame, surface.prepared(settings.truncation_m), _lifted(kept, surface, lifting))


def _lifted(kept: PackedFrame, surface: ObservedSurface, lifting: LiftingSettings) -> Lifted:
    """The detections and what else masks hold, where their readings lie now."""
    reading = np.zeros(surface.depth.size, np.int32)
    reading[surface.rows * surface.depth.shape[1] + surface.columns] = np.arange(len(surface.rows), dtype=np.int32)
    pixels = np.cumsum(np.ascontiguousarray(_inflated(kept.pixels, 4)).view(np.int32)[:, 0], dtype=np.int32)
    readings = reading[pixels]
    lengths = [length for _, length, *_ in kept.properties]
    n = len(lengths)
    member, member_cell, _ = occupied_cells(surface, n, np.repeat(np.arange(n), lengths), readings)
    order = np.argsort(member, kind="stable")
    cells_of = np.split(member_cell[order], np.searchsorted(member[order], np.arange(1, n)))
    readings_of = np.split(readings, np.cumsum(lengths)[:-1])
    embeddings = _unit(kept.embeddings)
    detections = []
    for i, (mask, _, score, quality, class_name, region, is_stuff) in enumerate(kept.properties):
        moments, box = fit_box(surface, cells_of[i], readings_of[i], lifting)
        fields = (
            mask,
            cells_of[i],
            readings_of[i],
            moments,
            box,
            embeddings[i],
            score,
            quality,
            class_name,
            region,
            is_stuff,
            view_sector(moments.mean, surface.world_from_camera[:3, 3]),
        )
        detections.append(Detection(*fields))
    masks = np.array([mask for mask, *_ in kept.properties], np.int32)
    leftover_cells = surface.pixel_cell[reading[kept.leftover_pixels]]
    member_mask = np.concatenate([masks[member], kept.leftover_masks])
    return Lifted(tuple(detections), member_mask, np.concatenate([member_cell, leftover_cells]))


def _quantized(embeddings: list[Float32Array]) -> NDArray[np.int8]:
    """Unit vectors (N, D) as int8, the largest part of each being 127."""
    if not embeddings:
        return np.zeros((0, 1), np.int8)
    vectors = np.stack(embeddings)
    return np.rint(vectors * (127 / np.maximum(np.abs(vectors).max(axis=1, keepdims=True), 1e-12))).astype(np.int8)


def _unit(quantized: NDArray[np.int8]) -> Float32Array:
    vectors = quantized.astype(np.float32)
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def _packed_bits(image: BoolArray) -> bytes:
    return zlib.compress(np.packbits(image).tobytes(), 1)


def _unpacked_bits(packed: bytes, shape: tuple[int, int]) -> BoolArray:
    bits = np.frombuffer(zlib.decompress(packed), np.uint8)
    return np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape).astype(np.bool_)


def _inverse_depth(depth: Float32Array) -> Uint16Array:
    with np.errstate(divide="ignore"):
        steps = np.rint(np.float32(1 / INVERSE_DEPTH_STEP) / depth)
    return np.where(depth > 0, np.clip(steps, 1, 65535), 0).astype(np.uint16)


def _depth_m(steps: Uint16Array) -> Float32Array:
    return np.where(steps > 0, np.float32(1 / INVERSE_DEPTH_STEP) / np.maximum(steps, 1), 0).astype(np.float32)


def _delta_coded(image: Uint16Array) -> bytes:
    """Differences of neighbours, small ones of either sign as small numbers."""
    difference = np.diff(image.ravel(), prepend=np.uint16(0)).view(np.int16)
    return _deflated(((difference << 1) ^ (difference >> 15)).view(np.uint8).reshape(-1, 2))


def _delta_decoded(packed: bytes, shape: tuple[int, int]) -> Uint16Array:
    folded = np.ascontiguousarray(_inflated(packed, 2)).view(np.uint16)
    difference = (folded >> 1) ^ -(folded & 1)
    return np.cumsum(difference, dtype=np.uint16).reshape(shape)


def _deflated(rows: Uint8Array) -> bytes:
    """The bytes of (N, B), first all the lowest ones, then the next: runs, which are quick to find."""
    compressor = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_RLE)
    return compressor.compress(rows.T.tobytes()) + compressor.flush()


def _inflated(packed: bytes, n_bytes: int) -> Uint8Array:
    return np.frombuffer(zlib.decompress(packed), np.uint8).reshape(n_bytes, -1).T
