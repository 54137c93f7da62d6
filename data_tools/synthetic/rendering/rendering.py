"""The images that a renderer makes of one view."""

from __future__ import annotations

from typing import NamedTuple

from razer.arrays import Float32Array, Int32Array, Uint8Array


class Rendering(NamedTuple):
    """Colour (H, W, 3) uint8; depth (H, W) float32 metres, 0 = nothing; instance ids (H, W) int32, 0 = nobody; parts
    (H, W) uint8, numbers within each instance from 1, None where the world has none."""

    rgb: Uint8Array
    depth: Float32Array
    ids: Int32Array
    parts: Uint8Array | None
