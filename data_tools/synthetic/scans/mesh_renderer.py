"""Ray casting of a labelled mesh: vertex colours interpolated, instances by the nearest corner."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.rendering.rendering import Rendering
from data_tools.synthetic.scans.surface import ScannedSurface
from razer.arrays import Float64Array
from razer.frame import Intrinsics


class MeshRenderer:
    """Renders a surface from any pose in a world that surface_from_world (4, 4) takes to the frame of the surface; a
    pure function of the pose.

    Where a ray meets nothing, or the back of a surface that was scanned from the other side, there is nothing: colour
    is black and depth 0. The back hides what is behind it all the same, as what was scanned does.
    """

    def __init__(self, surface: ScannedSurface, camera: Intrinsics, surface_from_world: Float64Array) -> None:
        self.scene = surface.scene
        self._surface, self._surface_from_world = surface, surface_from_world
        u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], axis=-1)
        self._rays = rays.astype(np.float32)

    def render(self, world_from_camera: Float64Array) -> Rendering:
        """What the camera at this pose sees; a scan has no parts."""
        surface, pose = self._surface, (self._surface_from_world @ world_from_camera).astype(np.float32)
        # Rays are one metre long along the optical axis: how far along them is depth.
        depth, triangle, weights = surface.cast(pose[:3, 3], self._rays @ pose[:3, :3].T)
        seen = triangle >= 0
        corners, weights = surface.triangles[triangle[seen]], weights[seen]
        rgb, ids = np.zeros((*seen.shape, 3), np.uint8), np.zeros(seen.shape, np.int32)
        rgb[seen] = np.rint(np.einsum("nk,nkc->nc", weights, surface.colors[corners].astype(np.float32))).clip(0, 255)
        nearest = np.take_along_axis(corners, weights.argmax(axis=1)[:, None], axis=1)[:, 0]
        ids[seen] = surface.instances[nearest].clip(0)
        return Rendering(rgb, np.where(seen, depth, np.float32(0)), ids, None)
