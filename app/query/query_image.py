"""Query by image: the embedding of a picture, or of a box of it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Uint8Array
from razer.errors import BadInput
from razer.files import decode_image, read_bytes
from razer.models import Embedder, ImageEncoder

_MAX_BYTES = 256 * 2**20


def embed_query_image(embedder: Embedder, name: str, path: Path, box: str | None) -> Float32Array:
    """The vector (D,) of what a picture shows.

    Args:
        embedder: the embedder of the map.
        name: what messages call it.
        path: an image file.
        box: 'x,y,width,height' in pixels of the part to embed; None: the whole picture.

    Raises:
        BadInput: if the embedder embeds no images, the file is no image, or the box lies outside it.
    """
    if not isinstance(embedder, ImageEncoder):
        raise BadInput(f"embedder '{name}' has no image encoder: ask by words, or map with another --embedder")
    rgb = _read(path)
    return embedder.embed_region(rgb, _mask(box, rgb.shape, path))


def _read(path: Path) -> Uint8Array:
    try:
        return decode_image(read_bytes(path, _MAX_BYTES), str(path), cv2.IMREAD_COLOR_RGB)
    except BadInput as error:
        raise BadInput(f"{error}: give a .png or .jpg") from None


def _mask(box: str | None, shape: tuple[int, ...], path: Path) -> BoolArray:
    mask = np.zeros(shape[:2], np.bool_)
    mask[_window(box, shape, path)] = True
    return mask


def _window(box: str | None, shape: tuple[int, ...], path: Path) -> tuple[slice, slice]:
    if box is None:
        return slice(None), slice(None)
    try:
        x, y, width, height = (int(part) for part in box.split(","))
    except ValueError:
        raise BadInput(f"--box {box}: write it as x,y,width,height in pixels") from None
    if min(x, y) < 0 or min(width, height) < 1 or x + width > shape[1] or y + height > shape[0]:
        raise BadInput(f"--box {box} does not lie in {path}, which has {shape[1]}x{shape[0]} pixels")
    return slice(y, y + height), slice(x, x + width)
