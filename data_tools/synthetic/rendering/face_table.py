"""Face attributes of a scene as columns: plane, texture mapping and colour of each, from any camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_tools.synthetic.light.light_map import LightMap
from data_tools.synthetic.rendering.procedural_textures import SIZE
from data_tools.synthetic.shapes.solids import Solid, quad_normals
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float32Array, Float64Array, Int32Array, Int64Array, Uint8Array

LAST_PART = 255  # of a thing; further solids belong to it too, so that an image of parts has 8 bits


@dataclass(frozen=True, slots=True)
class FaceTable:
    """One row for each of F quads: a corner and outward normal (F, 3); texture coordinates in tiles as an affine
    function of the world point, uv_gradient (F, 2, 3) and uv_origin (F, 2); colour dark + span * grey, (F, 3) each with
    grey in 0..255, before light falls on it; column of the texture in the atlas; texels per metre; instance id; part,
    the number of the solid within its thing, from 1."""

    corners: Float64Array
    normals: Float64Array
    uv_gradient: Float64Array
    uv_origin: Float64Array
    dark: Float32Array
    span: Float32Array
    left: Float32Array
    texels_per_m: Float32Array
    instances: Int32Array
    parts: Uint8Array

    @classmethod
    def of(cls, things: Mapping[int, Thing], left: Mapping[str, int]) -> FaceTable:
        """The faces of all things in order; `left` is the atlas column of each texture."""
        solids = [
            (solid, number, part)
            for number, thing in things.items()
            for part, solid in enumerate(thing.solids, start=1)
        ]
        rows = [_columns(solid, number, part, left[solid.material.texture]) for solid, number, part in solids]
        return cls(*(np.concatenate(column) for column in zip(*rows, strict=True)))

    def planes_seen_from(
        self, world_from_camera: Float64Array, light: LightMap, number: Int64Array
    ) -> tuple[tuple[Float32Array, ...], Float32Array]:
        """For faces by number (F,), as linear functions (F, 3) of the ray (x, y, 1): 1/z, u/z, v/z, s/z and t/z with z
        the depth in metres, (u, v) in tiles and (s, t) in pixels of the light map; and the distance (F,) of the camera
        from the face's plane."""
        rotation, center = world_from_camera[:3, :3], world_from_camera[:3, 3]
        normals = self.normals[number]
        height = np.einsum("fk,fk->f", normals, self.corners[number] - center)
        height = np.where(np.abs(height) < 1e-6, 1e-6, height)
        inverse_depth = normals @ rotation / height[:, None]
        functions = [inverse_depth]
        for gradients, origins in ((self.uv_gradient, self.uv_origin), (light.gradient, light.origin)):
            gradient = gradients[number]
            at_center = origins[number] + gradient @ center
            both = at_center[:, :, None] * inverse_depth[:, None] + gradient @ rotation
            functions += [both[:, 0], both[:, 1]]
        return tuple(each.astype(np.float32) for each in functions), np.abs(height).astype(np.float32)


def _columns(solid: Solid, instance: int, part: int, left: int) -> tuple[NDArray, ...]:
    count = len(solid.quads)
    normals = quad_normals(solid.quads)
    gradient = _uv_gradient(solid)
    corners = solid.quads[:, 2]
    origin = solid.uv[:, 2] / solid.material.tile_m - np.einsum("fak,fk->fa", gradient, corners)
    dark, light = (np.broadcast_to(np.array(c, float), (count, 3)) for c in (solid.material.dark, solid.material.light))
    one = np.ones(count, np.float32)
    return (
        corners,
        normals,
        gradient,
        origin,
        dark.astype(np.float32),
        ((light - dark) / 255).astype(np.float32),
        one * left,
        one * np.float32(SIZE / solid.material.tile_m),
        np.full(count, instance, np.int32),
        np.full(count, min(part, LAST_PART), np.uint8),
    )


def _uv_gradient(solid: Solid) -> Float64Array:
    """The gradients (F, 2, 3) of the texture coordinates, in tiles per metre, along each quad's plane."""
    # Diagonals are never zero, also where two corners of a quad coincide.
    edges = np.stack([solid.quads[:, 2] - solid.quads[:, 0], solid.quads[:, 3] - solid.quads[:, 1]], axis=1)
    uv = np.stack([solid.uv[:, 2] - solid.uv[:, 0], solid.uv[:, 3] - solid.uv[:, 1]], axis=1)
    return np.swapaxes(np.linalg.pinv(edges) @ uv, 1, 2) / solid.material.tile_m
