"""Files of poses as other programs write them, each written out from its documentation."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

Matrices = Sequence[np.ndarray]
FEATURES = "10.5 20.5 -1 3.25 4.75 17"  # x, y and point of each, of COLMAP's second lines


def write_tum_lines(path: Path, stamps: Sequence[float], poses: Matrices) -> Path:
    rows = [(t, *p[:3, 3], *Rotation.from_matrix(p[:3, :3]).as_quat()) for t, p in zip(stamps, poses, strict=True)]
    path.write_text("# stamp tx ty tz qx qy qz qw\n" + "".join(" ".join(map(repr, map(float, r))) + "\n" for r in rows))
    return path


def write_kitti(path: Path, poses: Matrices) -> Path:
    np.savetxt(path, [pose[:3].ravel() for pose in poses])
    return path


def write_colmap(path: Path, names: Sequence[str], poses: Matrices) -> Path:
    lines = ["# Image list with two lines of data per image:", "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, ...", ""]
    for number, (name, pose) in enumerate(zip(names, poses, strict=True), 1):
        camera_from_world = np.linalg.inv(pose)
        x, y, z, w = Rotation.from_matrix(camera_from_world[:3, :3]).as_quat()
        lines.append(" ".join(map(str, (number, w, x, y, z, *camera_from_world[:3, 3], 1, name))))
        lines.append(FEATURES if number % 2 else "")
    path.write_text("\n".join(lines) + "\n")
    return path


def write_transforms(path: Path, names: Sequence[str], poses: Matrices) -> Path:
    """Columns of an OpenGL camera: right, up, and backwards."""
    frames = []
    for name, pose in zip(names, poses, strict=True):
        right, down, forward, position = pose.T
        frames.append({"file_path": name, "transform_matrix": np.stack([right, -down, -forward, position], 1).tolist()})
    path.write_text(json.dumps({"camera_angle_x": 0.7, "frames": frames}))
    return path


def curved_path(n_poses: int, step_m: float = 0.05) -> list[np.ndarray]:
    """Poses that move and turn about all axes."""
    poses = []
    for n in range(n_poses):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("xyz", (3 * n, 7 * n, -2 * n), degrees=True).as_matrix()
        pose[:3, 3] = step_m * n, 0.2 * np.sin(0.3 * n), -0.02 * n
        poses.append(pose)
    return poses
