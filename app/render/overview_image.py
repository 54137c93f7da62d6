"""Overview image of a map by ray casting: rooms from above with back faces culled, in colour and by instance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import open3d as o3d
import open3d.core as o3c

from app.render.name_tags import write_names
from app.render.palette import instance_colors
from razer.arrays import Float32Array, Float64Array, Int32Array, Int64Array, Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh

_FIELD_OF_VIEW_DEG = 45.0
_MAX_LAYERS = 8  # walls and ceilings seen from behind that a ray may pass through
_BACKGROUND = 255
_DIRECTIONS = 16
_ELEVATION = np.radians(48.0)


@dataclass(frozen=True)
class MapRendering:
    """The first triangle at each pixel (H, W) of a camera above a map, -1 = none, and facing (H, W), the cosine between
    its normal and the direction to the camera."""

    mesh: LabelledMesh
    triangle: Int64Array
    facing: Float64Array

    @property
    def instances(self) -> Int32Array:
        """The instance at each pixel (H, W), 0 = none."""
        corner = self.mesh.triangles[self.triangle, 0] if len(self.mesh.triangles) else np.zeros_like(self.triangle)
        labels = self.mesh.instances[corner] if len(self.mesh.instances) else np.zeros(corner.shape, np.int32)
        return np.where(self.triangle >= 0, labels, 0).astype(np.int32)

    def panel(self, colors: Uint8Array, blend: bool) -> Uint8Array:
        """Image (H, W, 3) of the map in the given colours (V, 3) of its vertices; triangles take mean or first."""
        covered = self.triangle >= 0
        image = np.full((*covered.shape, 3), _BACKGROUND, np.uint8)
        corners = self.mesh.triangles[self.triangle[covered]]
        flat = colors[corners].mean(axis=1) if blend else colors[corners[:, 0]]
        image[covered] = np.clip(flat * (0.45 + 0.55 * self.facing[covered, None]), 0, 255)
        return image


def render_from_above(mesh: LabelledMesh, up: Float64Array, width: int, height: int) -> MapRendering:
    """The map from above, from the side on which most of it is seen. Back faces are culled, so that one looks into
    rooms.

    Args:
        mesh: the labelled surface.
        up: (3,) the direction that is up in the world.
        width: of the image, pixels.
        height: of the image, pixels.
    """
    if len(mesh.triangles) == 0:
        return MapRendering(mesh, np.full((height, width), -1), np.zeros((height, width)))
    rays = _rays(mesh, up / np.linalg.norm(up), width, height)
    return MapRendering(mesh, *_first_front_faces(mesh, rays))


def overview_image(
    mesh: LabelledMesh,
    up: Float64Array,
    width: int = 1280,
    height: int = 560,
    names: Mapping[int, str] = MappingProxyType({}),
) -> Uint8Array:
    """RGB image (height, width, 3) uint8 with the map twice: left as coloured, right by instance, with its name.

    Args:
        mesh: the labelled surface.
        up: (3,) the direction that is up in the world.
        width: of the image, pixels.
        height: of the image, pixels.
        names: of instances, which are written on them.
    """
    rendering = render_from_above(mesh, up, width // 2, height)
    by_instance = rendering.panel(instance_colors(mesh.instances), blend=False)
    write_names(by_instance, rendering.instances, names)
    return np.concatenate([rendering.panel(mesh.colors, blend=True), by_instance], axis=1)


def _rays(mesh: LabelledMesh, up: Float64Array, width: int, height: int) -> Float32Array:
    """Rays (height, width, 6) of a camera above the map, on the side from which most of it is seen."""
    low, high = np.quantile(mesh.vertices.astype(np.float64), [0.01, 0.99], axis=0)
    middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    distance = 1.05 * radius / np.tan(np.radians(_FIELD_OF_VIEW_DEG) / 2)
    eye = middle + distance * _best_direction(mesh, up)
    # Open3D's rows run along its "up", so that it is given what is down.
    pinhole = (_FIELD_OF_VIEW_DEG, *(o3c.Tensor(v.astype(np.float32)) for v in (middle, eye, -up)), width, height)
    rays: Float32Array = o3d.t.geometry.RaycastingScene.create_rays_pinhole(*pinhole).numpy()
    return rays


def _best_direction(mesh: LabelledMesh, up: Float64Array) -> Float64Array:
    """Of the directions around the map, well above it, the one that most of its area faces."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]].astype(np.float64) for i in range(3))
    area = np.cross(b - a, c - a)
    side = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    turns = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
    around = np.cos(turns)[:, None] * side + np.sin(turns)[:, None] * np.cross(up, side)
    directions = np.sin(_ELEVATION) * up + np.cos(_ELEVATION) * around
    best: Float64Array = directions[np.clip(area @ directions.T, 0, None).sum(axis=0).argmax()]
    return best


def _first_front_faces(mesh: LabelledMesh, rays: Float32Array) -> tuple[Int64Array, Float64Array]:
    """The first triangle (H, W) whose front each ray meets, -1 = none, and the cosine of the angle of incidence."""
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3c.Tensor(mesh.vertices), o3c.Tensor(mesh.triangles.astype(np.uint32)))
    triangle, facing = np.full(rays.shape[:2], -1), np.zeros(rays.shape[:2])
    pending = np.argwhere(triangle < 0)
    directions = rays[..., 3:] / np.linalg.norm(rays[..., 3:], axis=2, keepdims=True)
    origins = rays[..., :3].copy()
    for _ in range(_MAX_LAYERS):
        pixels = tuple(pending.T)
        hits = scene.cast_rays(o3c.Tensor(np.concatenate([origins[pixels], directions[pixels]], axis=1)))
        distance, normals = hits["t_hit"].numpy(), hits["primitive_normals"].numpy()
        is_hit = np.isfinite(distance)
        cosine = -np.einsum("ij,ij->i", normals, directions[pixels])
        front = is_hit & (cosine > 0)
        triangle[pixels] = np.where(front, hits["primitive_ids"].numpy().astype(np.int64), -1)
        facing[pixels] = np.where(front, cosine, 0)
        origins[pixels] += directions[pixels] * np.where(is_hit, distance + 1e-3, 0)[:, None].astype(np.float32)
        pending = pending[is_hit & ~front]
        if len(pending) == 0:
            break
    return triangle, facing
