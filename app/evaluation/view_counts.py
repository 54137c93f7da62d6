"""Which true instances the frames of a run show: rays through its images, cast against the truth's surface."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from app.frames.open_recording import open_unchecked
from app.run_folder import run_folder as names
from app.settings.run_config import RunConfig
from data_tools.recordings.camera import read_camera_file
from razer.arrays import Float32Array, FloatArray, Int64Array, IntArray
from razer.errors import BadInput
from razer.frame import Intrinsics
from razer.metrics.scene_pair import TruthScene

# An instance is shown by a frame that has this share of its image on it: 400 of 640 x 480 pixels, what detectors find.
MIN_IMAGE_SHARE = 400 / (640 * 480)
# Rays across an image. At this width an instance of the least share gets 16; more change the counts by less than that.
_RAYS_ACROSS = 128


class ViewCounter:
    """Counts in how many of some poses each true instance is shown: it fills a share of the image, at a depth that is
    mapped, with nothing of the truth before it. What moved during the recording is taken to be where the truth has it.
    """

    def __init__(
        self, truth: TruthScene, triangles: IntArray, camera: Intrinsics, range_m: tuple[float, float]
    ) -> None:
        """`triangles` (T, 3) are those of the truth; range_m: the least and the largest depth that is mapped."""
        import open3d as o3d  # late, as in all verbs

        self._tensor = o3d.core.Tensor
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(
            self._tensor.from_numpy(np.array(truth.vertices, np.float32)),
            self._tensor.from_numpy(np.array(triangles, np.uint32)),
        )
        self._owners = _owners(truth.instances, triangles)
        self._directions = _pixel_rays(camera)
        self._range_m = range_m

    def __call__(self, world_from_camera: FloatArray) -> dict[int, int]:
        """The number of the poses (N, 4, 4), in the truth's frame, that show each true instance; 0 is left out."""
        counts: Counter[int] = Counter()
        for pose in world_from_camera:
            counts.update(self._shown(pose))
        return dict(counts)

    def _shown(self, pose: FloatArray) -> list[int]:
        rays = np.empty((len(self._directions), 6), np.float32)
        rays[:, :3], rays[:, 3:] = pose[:3, 3], self._directions @ pose[:3, :3].T
        hits = self._scene.cast_rays(self._tensor.from_numpy(rays), nthreads=1)
        depth, triangle = hits["t_hit"].numpy(), hits["primitive_ids"].numpy()
        is_mapped = (depth >= self._range_m[0]) & (depth <= self._range_m[1])  # a miss is infinitely far
        ids, pixels = np.unique(self._owners[triangle[is_mapped]], return_counts=True)
        is_shown = (ids > 0) & (pixels >= MIN_IMAGE_SHARE * len(rays))
        return [int(i) for i in ids[is_shown]]


def view_counter(run: Path, config: RunConfig, truth: TruthScene) -> ViewCounter | None:
    """What counts the views of a run, None where its camera is not known, or the truth has no surface."""
    camera = _camera_of(run, config)
    if camera is None or truth.triangles is None or not len(truth.triangles):
        return None
    return ViewCounter(truth, truth.triangles, camera, (config.voxels.depth_min_m, config.voxels.depth_max_m))


def _camera_of(run: Path, config: RunConfig) -> Intrinsics | None:
    """The camera that the run kept, or else that of its recording, if this is still there."""
    if (run / names.CAMERA).is_file():
        camera = read_camera_file(run / names.CAMERA).depth_camera
        return None if camera is None or camera.size is None else camera.at(camera.size)
    if config.input.folder is None:
        return None
    try:
        return open_unchecked(Path(config.input.folder), config.input).intrinsics
    except BadInput:
        return None


def _owners(instances: IntArray, triangles: IntArray) -> Int64Array:
    """The instance of each triangle (T,): that of two of its corners, or of the first."""
    first, second, third = np.asarray(instances, np.int64)[np.asarray(triangles)].T
    return np.where(second == third, second, first)


def _pixel_rays(camera: Intrinsics) -> Float32Array:
    """Directions (R, 3) in the camera's axes, 1 m deep, through the pixels of a small image."""
    width = min(_RAYS_ACROSS, camera.width)
    small = camera.resized(width, max(1, round(width * camera.height / camera.width)))
    u, v = np.meshgrid(np.arange(small.width), np.arange(small.height))
    x, y = (u - small.cx) / small.fx, (v - small.cy) / small.fy
    return np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3).astype(np.float32)
