"""Pictures from outside, decoded within bounds: the kind and the size are known before a pixel is."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError

from razer.arrays import Uint8Array
from razer.errors import BadInput

MAX_BYTES = 10 * 2**20
MAX_PIXELS = 40_000_000  # a telephone's largest; 120 MB while it is decoded
MAX_EDGE_PX = 1024  # encoders look at 224 to 448 pixels
_KINDS = ("PNG", "JPEG")


def decoded_picture(data: bytes) -> Uint8Array:
    """The picture (H, W, 3) uint8 in a PNG or JPEG file, scaled down to 1024 pixels; raises BadInput for anything else,
    for what is damaged, and for more than 40 million pixels, of which none is decoded."""
    if not data:
        raise BadInput("the picture is empty: send a PNG or JPEG file")
    try:
        with Image.open(BytesIO(data), formats=_KINDS) as picture:
            return _pixels(picture)
    except UnidentifiedImageError:
        raise BadInput("the picture is neither PNG nor JPEG: send one of these") from None
    except (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError, MemoryError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput("the picture is damaged: send a whole PNG or JPEG file") from None


def _pixels(picture: Image.Image) -> Uint8Array:
    width, height = picture.size
    if width * height > MAX_PIXELS:
        raise BadInput(f"the picture has {width} x {height} pixels: send one of {MAX_PIXELS // 10**6} million at most")
    picture.draft("RGB", (MAX_EDGE_PX, MAX_EDGE_PX))  # a JPEG is decoded at the size that is needed
    upright = ImageOps.exif_transpose(picture).convert("RGB")
    upright.thumbnail((MAX_EDGE_PX, MAX_EDGE_PX))
    return np.array(upright, np.uint8)
