"""Tiny inputs for the tests of the method: poses, depth of world planes and boxes, frames, cells, detections."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import VoxelSettings
from razer.detection.lifting import Detection
from razer.detection.observed_surface import BLOCK_VOXELS, Cells, ObservedSurface, cells_of
from razer.frame import Frame, Intrinsics
from razer.volume.voxel_map import VoxelMap

CAMERA = Intrinsics(160, 120, 140.0, 140.0, 79.5, 59.5)
# 4 cm, so that neighbouring pixels of CAMERA share or touch voxels out to 5 m; the truncation is 16 cm.
COARSE = VoxelSettings(voxel_size_m=0.04, truncation_voxels=4.0, depth_max_m=5.0)


def pose(position: ArrayLike = (0, 0, 0), turn_deg: ArrayLike = (0, 0, 0)) -> np.ndarray:
    """world_from_camera of a camera at `position`, turned by Euler angles about x, y, z."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", turn_deg, degrees=True).as_matrix()
    result[:3, 3] = position
    return result


def world_rays(world_from_camera: np.ndarray, camera: Intrinsics = CAMERA) -> np.ndarray:
    """Rays (H, W, 3) through all pixels, as long as one metre of depth, in world axes."""
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], axis=-1)
    return rays @ world_from_camera[:3, :3].T


def plane_depth(
    world_from_camera: np.ndarray, normal: ArrayLike, distance_m: float, camera: Intrinsics = CAMERA
) -> np.ndarray:
    """Depth (H, W) of the world plane normal . X = distance, infinite where it is not hit."""
    along = world_rays(world_from_camera, camera) @ np.asarray(normal, float)
    gap = distance_m - np.asarray(normal, float) @ world_from_camera[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = gap / along
    return np.where(depth > 0, depth, np.inf)


def box_depth(world_from_camera: np.ndarray, box: OrientedBox, camera: Intrinsics = CAMERA) -> np.ndarray:
    """Depth (H, W) of a box, infinite where it is not hit (slab method)."""
    rays = world_rays(world_from_camera, camera) @ box.rotation
    rays = np.where(np.abs(rays) < 1e-9, 1e-9, rays)
    origin = (world_from_camera[:3, 3] - box.center) @ box.rotation
    one, two = (-box.extent / 2 - origin) / rays, (box.extent / 2 - origin) / rays
    enter, leave = np.minimum(one, two).max(axis=-1), np.maximum(one, two).min(axis=-1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)


def frame_of(
    depth_m: np.ndarray,
    world_from_camera: np.ndarray | None = None,
    *,
    index: int = 0,
    rgb: tuple[int, int, int] = (200, 100, 50),
    camera: Intrinsics = CAMERA,
) -> Frame:
    """A frame of one colour; depth that is not finite becomes 0, no reading."""
    depth = np.where(np.isfinite(depth_m), depth_m, 0).astype(np.float32)
    colour = np.broadcast_to(np.array(rgb, np.uint8), (*depth.shape, 3)).copy()
    at = np.eye(4) if world_from_camera is None else world_from_camera
    return Frame(index, index / 30, colour, depth, camera, at)


def look(frame: Frame, settings: VoxelSettings = COARSE) -> ObservedSurface:
    """The surface a frame shows, at the map's resolution."""
    return ObservedSurface.of(frame, settings.voxel_size_m, settings.depth_min_m, settings.depth_max_m)


def cells_at(coordinates: ArrayLike, voxel_size_m: float = 0.04) -> Cells:
    """The cells with the given lattice coordinates."""
    return cells_of(np.asarray(coordinates, np.int32).reshape(-1, 3), voxel_size_m)[0]


def axis_box(center: ArrayLike, extent: ArrayLike) -> OrientedBox:
    """A box along the world's axes."""
    return OrientedBox(np.asarray(center, float), np.eye(3), np.asarray(extent, float))


def random_box(rng: np.random.Generator, spread_m: float = 0.5) -> OrientedBox:
    """A box of 0.2 to 1 m edges, turned anyhow, near the origin."""
    rotation = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    return OrientedBox(rng.uniform(-spread_m, spread_m, 3), rotation, rng.uniform(0.2, 1.0, 3))


def moved(box: OrientedBox, transform: np.ndarray) -> OrientedBox:
    """The box after a rigid motion."""
    return OrientedBox(transform[:3, :3] @ box.center + transform[:3, 3], transform[:3, :3] @ box.rotation, box.extent)


def unit(*values: float) -> np.ndarray:
    """A float32 vector of unit length."""
    vector = np.array(values, np.float64)
    return (vector / np.linalg.norm(vector)).astype(np.float32)


def detection(
    box: OrientedBox,
    embedding: ArrayLike = (1.0, 0.0),
    *,
    cells: Sequence[int] = (),
    mask: int = 0,
    quality: float = 0.5,
    score: float = 1.0,
    class_name: str | None = None,
) -> Detection:
    """A detection whose points are the corners of a box."""
    corners = box.corners()
    return Detection(
        mask=mask,
        cells=np.array(cells, np.int32),
        pixels=np.zeros(0, np.int32),
        moments=PointMoments.of(corners),
        box=box,
        embedding=np.asarray(embedding, np.float32),
        score=score,
        quality=quality,
        class_name=class_name,
    )


ATTRIBUTES = ("tsdf", "weight", "color", "label", "ids", "counts")


def contents(voxels: VoxelMap) -> dict[str, np.ndarray]:
    """Keys (B, 3) of the blocks in use and every attribute (B, 4096, channels), in the order of the keys."""
    keys, rows = voxels.pages.all()
    parts = {name: voxels.pages.blocks(rows, name).cpu().numpy() for name in ATTRIBUTES}
    return {"keys": keys, **parts}


def fill(voxels: VoxelMap, **values: np.ndarray) -> None:
    """Set attributes (B, 4096, channels) of the blocks in use, in the order of their keys."""
    rows = voxels.pages.all()[1]
    addresses = (rows[:, None] * BLOCK_VOXELS + torch.arange(BLOCK_VOXELS, device=rows.device)).flatten()
    for name, value in values.items():
        dtype = voxels.pages.blocks(rows[:1], name).dtype
        voxels.pages.write(addresses, **{name: torch.from_numpy(value).to(rows.device, dtype).flatten(0, 1)})


def same_contents(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> bool:
    """Whether two maps hold the same, bit for bit."""
    return all(one[name].tobytes() == other[name].tobytes() for name in one)
