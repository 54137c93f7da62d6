"""Ray casting of colour, depth and instance images."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import cv2
import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from data_tools.synthetic.light.emitters import Light
from data_tools.synthetic.light.light_map import FULL, LightMap, light_map
from data_tools.synthetic.rendering.face_table import FaceTable
from data_tools.synthetic.rendering.procedural_textures import SIZE
from data_tools.synthetic.rendering.rendering import Rendering
from data_tools.synthetic.rendering.texture_atlas import LEVELS, paint_atlas
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float32Array, Float64Array, Int64Array, Uint8Array
from razer.frame import Intrinsics

_SOFT = np.array([0.2, 0.6, 0.2])
_LEVELS = np.arange(256) / 255
# A camera's curve: steeper in the middle, flat at black and white.
_CONTRAST = np.rint(255 * (0.4 * _LEVELS + 0.6 * _LEVELS**2 * (3 - 2 * _LEVELS))).astype(np.uint8)


class RayRenderer:
    """Renders a fixed set of things (instance id -> Thing) from any pose; a pure function of the pose."""

    def __init__(
        self, things: Mapping[int, Thing], intrinsics: Intrinsics, texture_seed: int = 0, light: Light = "day"
    ) -> None:
        self.intrinsics = intrinsics
        self._things, self._light = things, light
        self._atlas = paint_atlas(texture_seed)
        self._faces = FaceTable.of(things, self._atlas.left)
        self.scene = scene_of(things)
        u, v = np.arange(intrinsics.width), np.arange(intrinsics.height)
        self._x = ((u - intrinsics.cx) / intrinsics.fx).astype(np.float32)
        self._y = ((v - intrinsics.cy) / intrinsics.fy).astype(np.float32)
        self._ray_length = np.sqrt(self._x**2 + self._y[:, None] ** 2 + 1)

    def render(self, world_from_camera: Float64Array) -> Rendering:
        """What the camera at this pose sees; each solid of a thing is a part of it."""
        faces = self._seen_faces(world_from_camera)
        nothing = faces < 0
        faces[nothing] = 0
        # Of a large world most faces are out of view.
        in_view = np.flatnonzero(np.bincount(faces.ravel(), minlength=len(self._faces.corners)))
        row = np.empty(len(self._faces.corners), np.int64)
        row[in_view] = np.arange(len(in_view))
        rows = row.take(faces)
        planes, distance_m = self._faces.planes_seen_from(world_from_camera, self._light_map, in_view)
        inverse_depth, tile_u, tile_v, light_x, light_y = planes
        depth = np.reciprocal(np.maximum(self._evaluate(inverse_depth, rows), np.float32(1e-6)))
        u: Float32Array = self._evaluate(tile_u, rows) * depth
        v: Float32Array = self._evaluate(tile_v, rows) * depth
        grey = self._sample(faces, u, v, depth * depth * self._ray_length / distance_m.take(rows))
        x, y = (self._evaluate(place, rows) * depth for place in (light_x, light_y))
        shade = cv2.remap(self._light_map.image, x, y, cv2.INTER_LINEAR)
        rgb = self._developed(self._tint(faces, grey), shade)
        ids, parts = self._faces.instances.take(faces), self._faces.parts.take(faces)
        rgb[nothing], depth[nothing], ids[nothing], parts[nothing] = 0, 0, 0, 0
        return Rendering(rgb, depth, ids, parts)

    @cached_property
    def _light_map(self) -> LightMap:
        # Late: much of what is done with a world needs no picture of it.
        return light_map(self._things, self.scene, self._light)

    def _seen_faces(self, world_from_camera: Float64Array) -> Int64Array:
        """The face seen at each pixel, -1 = none. Rays go through every other pixel of every other row, and
        through those in between whose neighbours disagree: only details of one pixel can slip through."""
        height, width = len(self._y), len(self._x)
        coarse = self._cast(np.arange(0, height, 2)[:, None], np.arange(0, width, 2)[None], world_from_camera)
        padded = np.pad(coarse, (0, 1), constant_values=-2)
        same = coarse == padded[1:, 1:]
        same &= (coarse == padded[:-1, 1:]) & (coarse == padded[1:, :-1])
        faces = coarse.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]
        unsure = ~same.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]
        unsure[::2, ::2] = False
        rows, columns = np.nonzero(unsure)
        faces[rows, columns] = self._cast(rows, columns, world_from_camera)
        return faces

    def _cast(self, rows: NDArray, columns: NDArray, world_from_camera: Float64Array) -> Int64Array:
        """The face hit by the ray through each pixel, -1 = none."""
        x, y = np.broadcast_arrays(self._x[columns], self._y[rows])
        rays = np.empty((*x.shape, 6), np.float32)
        rays[..., :3] = world_from_camera[:3, 3]
        rays[..., 3:] = np.stack([x, y, np.ones_like(x)], axis=-1) @ world_from_camera[:3, :3].T.astype(np.float32)
        triangles = self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays))["primitive_ids"].numpy()
        # Two triangles a face; "no triangle" is all ones, so -1, and stays -1.
        return (triangles.view(np.int32) >> 1).astype(np.int64)

    def _evaluate(self, coefficients: Float32Array, faces: Int64Array) -> Float32Array:
        """A linear function of the ray (x, y, 1) per face (F, 3), evaluated at every pixel."""
        a, b, c = (np.ascontiguousarray(column).take(faces) for column in coefficients.T)
        a *= self._x
        b *= self._y[:, None]
        a += b
        a += c
        return a

    def _sample(self, faces: Int64Array, u: Float32Array, v: Float32Array, area: Float32Array) -> Float32Array:
        """Look the texture up at (u, v) tiles, from the mipmap whose pixels are as large as the view's."""
        footprint = area * self._faces.texels_per_m.take(faces) / np.float32(self.intrinsics.fx)
        level = np.clip(np.log2(np.maximum(footprint, 1)) + 0.3, 0, LEVELS - 1).astype(np.int64)
        size = (SIZE / 2.0 ** np.arange(LEVELS)).astype(np.float32).take(level)
        x = (u - np.floor(u)) * size + (self._faces.left.take(faces) - np.float32(0.5))
        y = (v - np.floor(v)) * size + (self._atlas.top.take(level) - np.float32(0.5))
        return cv2.remap(self._atlas.image, x, y, cv2.INTER_LINEAR).astype(np.float32)

    def _tint(self, faces: Int64Array, grey: Float32Array) -> Float32Array:
        rgb = self._faces.span.take(faces, axis=0)
        rgb *= grey[..., None]
        rgb += self._faces.dark.take(faces, axis=0)
        return rgb

    def _developed(self, rgb: Float32Array, shade: Uint8Array) -> Uint8Array:
        """Colours under light as a camera shows them: edges a little soft, as no pixel is a point, and its contrast."""
        lit = cv2.multiply(rgb, shade, scale=1 / FULL, dtype=cv2.CV_8U)
        if self._light == "even":
            return lit
        soft = cv2.sepFilter2D(lit, -1, _SOFT, _SOFT)
        developed: Uint8Array = cv2.LUT(soft, _CONTRAST)
        return developed


def scene_of(things: Mapping[int, Thing]) -> o3d.t.geometry.RaycastingScene:
    """The quads of all things as two triangles each, in the order of FaceTable."""
    quads = np.concatenate([solid.quads for thing in things.values() for solid in thing.solids])
    triangles = (4 * np.arange(len(quads))[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    scene = o3d.t.geometry.RaycastingScene()
    to_tensor = o3d.core.Tensor.from_numpy
    scene.add_triangles(to_tensor(quads.reshape(-1, 3).astype(np.float32)), to_tensor(triangles.astype(np.uint32)))
    return scene
