"""Images within bounds: the size is known, and the end is there, before a pixel is decoded."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.errors import BadInput

MAX_PIXELS = 100_000_000  # 300 MB in colour, while it is decoded
_PNG, _JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
_PNG_END, _JPEG_END = b"IEND", b"\xff\xd9"
_MAX_DEFLATION = 1032  # no more bytes come of one
_ENDING_BYTES = 1024  # some cameras pad their files
_FRAME_HEADERS = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_LONE_MARKERS = {0x01, *range(0xD0, 0xD9)}
_BLOCK_PX = 8  # side of the smallest unit of a JPEG
_NOTHING_DECODED = 128  # grey, which a JPEG's decoder gives to units whose data has ended
_MORE_DATA = b"\x55" * 64


def decode_image(data: bytes, name: str, flags: int) -> NDArray:
    """The image in the bytes of a PNG or JPEG file, by OpenCV's flags; raises BadInput naming it, also for one that is
    cut off, even with an end put after it, and for more than 100 million pixels, of which none is decoded."""
    if not data:
        raise BadInput(f"{name} is empty")
    width, height = image_size(data, name)
    if not 0 < width * height <= MAX_PIXELS:
        raise BadInput(f"{name} has {width} x {height} pixels where {MAX_PIXELS // 10**6} million are the most")
    if (_PNG_END if data.startswith(_PNG) else _JPEG_END) not in data[-_ENDING_BYTES:]:
        raise BadInput(f"{name} is truncated")
    if data.startswith(_PNG) and not _has_whole_chunks(data):
        raise BadInput(f"{name} is no image, or a damaged one")
    if data.startswith(_PNG) and width * height * data[24] > 8 * _MAX_DEFLATION * len(data):
        raise BadInput(f"{name} is damaged: it is too short for {width} x {height} pixels")
    image = _decoded(data, flags)
    if image is None or image.shape[0] * image.shape[1] != width * height:
        raise BadInput(f"{name} is no image, or a damaged one")
    if data.startswith(_JPEG) and _ends_grey(image) and _depends_on_more(data, image, flags):
        raise BadInput(f"{name} is damaged: its data ends before the last pixels")
    return image


def image_size(data: bytes, name: str) -> tuple[int, int]:
    """(width, height) by the header of a PNG or JPEG file; raises BadInput for any other."""
    if data.startswith(_PNG) and data[12:16] == b"IHDR" and len(data) >= 24:
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    if data.startswith(_JPEG):
        for marker, start, length in _segments(data):
            if marker in _FRAME_HEADERS and length >= 7:
                height, width = struct.unpack(">HH", data[start + 1 : start + 5])
                return width, height
    raise BadInput(f"{name} is no image, or a damaged one: give a PNG or JPEG file")


def _has_whole_chunks(data: bytes) -> bool:
    """Whether the chunks of a PNG lie one behind the other to the last one, with the sums that they should have.
    Decoders make room for as much as a chunk says that it holds."""
    at = len(_PNG)
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4], "big")
        if end + 4 > len(data):
            return False
        if zlib.crc32(memoryview(data)[at + 4 : end]) != int.from_bytes(data[end : end + 4], "big"):
            return False
        if data[at + 4 : at + 8] == _PNG_END:
            return True
        at = end + 4
    return False


def _segments(data: bytes) -> Iterator[tuple[int, int, int]]:
    """(marker, first byte of content, bytes of content) of the segments of a JPEG before its pixels."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:  # fill
            at += 1
        elif marker in _LONE_MARKERS:
            at += 2
        else:
            length = int.from_bytes(data[at + 2 : at + 4], "big")
            if length < 2 or at + 2 + length > len(data):
                return
            yield marker, at + 4, length - 2
            at += 2 + length


def _decoded(data: bytes, flags: int) -> NDArray | None:
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error:
        return None


def _ends_grey(image: NDArray) -> bool:
    """Whether the last block is what a decoder makes of nothing; turned images end at another corner."""
    ends = (slice(-_BLOCK_PX, None), slice(_BLOCK_PX))
    return any(bool((image[y, x] == _NOTHING_DECODED).all()) for y in ends for x in ends)


def _depends_on_more(data: bytes, image: NDArray, flags: int) -> bool:
    """Whether the decoder wanted more data than there is: with some more before the end, it gives another image."""
    end = data.rindex(_JPEG_END)
    other = _decoded(data[:end] + _MORE_DATA + data[end:], flags)
    return other is None or not np.array_equal(other, image)
