"""Pictures from outside: what is decoded, and what is refused before it is."""

from __future__ import annotations

import struct
import tracemalloc
import zlib
from contextlib import suppress
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from app.served_map.query_picture import MAX_EDGE_PX, decoded_picture
from razer.errors import BadInput

SVG = b'<svg xmlns="http://www.w3.org/2000/svg"><script>alert(1)</script></svg>'


def encoded(kind: str, size=(40, 30), mode="RGB", **options) -> bytes:
    file = BytesIO()
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (size[1], size[0], len(mode)), np.uint8).squeeze()
    Image.fromarray(pixels, mode=None).convert(mode).save(file, kind, **options)
    return file.getvalue()


def png_bomb(width: int, height: int) -> bytes:
    """A PNG of a few kilobytes that says it has many pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    content = zlib.compress(bytes(4_000_000), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", content) + chunk(b"IEND", b"")


def test_pixels_are_those_of_the_file():
    data = encoded("PNG")
    assert (decoded_picture(data) == np.array(Image.open(BytesIO(data)))).all()


@pytest.mark.parametrize(("kind", "mode"), [("PNG", "RGBA"), ("PNG", "L"), ("JPEG", "L"), ("JPEG", "RGB")])
def test_any_mode_becomes_rgb(kind, mode):
    assert decoded_picture(encoded(kind, mode=mode)).shape == (30, 40, 3)


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
def test_large_pictures_are_scaled_down(kind):
    picture = decoded_picture(encoded(kind, (3000, 1500)))
    assert max(picture.shape) <= MAX_EDGE_PX
    assert picture.shape[1] == pytest.approx(2 * picture.shape[0], abs=2)


def test_a_turned_photograph_is_set_upright():
    exif = Image.Exif()
    exif[0x0112] = 6  # a quarter turn
    assert decoded_picture(encoded("JPEG", (40, 30), exif=exif)).shape[:2] == (40, 30)


@pytest.mark.parametrize(
    "data",
    [b"", b"no picture", SVG, b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF89a" + bytes(100), b"%PDF-1.7", b"PK\x03\x04",
     encoded("GIF"), encoded("BMP"), encoded("TIFF"), encoded("WEBP"), b"<?xml?>" + encoded("PNG")],
)  # fmt: skip
def test_anything_else_is_refused(data):
    with pytest.raises(BadInput, match="picture"):
        decoded_picture(data)


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
@pytest.mark.parametrize("share", [0.05, 0.3, 0.7, 0.95])
def test_half_a_file_is_refused(kind, share):
    data = encoded(kind, (200, 200))
    with pytest.raises(BadInput, match="picture"):
        decoded_picture(data[: int(share * len(data))])


def test_flipped_bytes_are_refused_or_decoded_but_never_crash():
    rng = np.random.default_rng(0)
    for kind in ("PNG", "JPEG"):
        data = encoded(kind, (64, 64))
        for _ in range(200):
            spoilt = np.frombuffer(data, np.uint8).copy()
            spoilt[rng.integers(0, len(spoilt), 5)] = rng.integers(0, 256, 5)
            with suppress(BadInput):
                assert decoded_picture(spoilt.tobytes()).dtype == np.uint8


@pytest.mark.parametrize("size", [(60_000, 60_000), (2**31 - 1, 1_000), (8_000, 8_000)])
def test_a_bomb_is_refused_before_a_pixel_is_decoded(size):
    data = png_bomb(*size)
    assert len(data) < 10_000
    tracemalloc.start()
    with pytest.raises(BadInput):
        decoded_picture(data)
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


def test_what_follows_a_picture_is_left_aside():
    """A file that is a picture and a page at once is a picture here, and is never sent back."""
    data = encoded("PNG")
    assert (decoded_picture(data + b"<script>alert(1)</script>") == decoded_picture(data)).all()
