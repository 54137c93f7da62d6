"""Hand-made recordings of a few tiny images, written as files."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

WIDTH, HEIGHT = 8, 6
CAMERA_MATRIX = "10 0 3.5\n0 10 2.5\n0 0 1\n"


def write_image(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    flipped = image[..., ::-1] if image.ndim == 3 else image
    path.write_bytes(cv2.imencode(path.suffix, flipped)[1].tobytes())


def colour(value: int = 0, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """Red = value, green = column, blue = row, so that every pixel can be told apart."""
    rows, columns = np.mgrid[:height, :width]
    return np.stack([np.full_like(rows, value), columns, rows], axis=-1).astype(np.uint8)


def depth(units: int = 1000, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    return np.full((height, width), units, np.uint16)


def write_seven_scenes(folder: Path, frames: int = 3, intrinsics: bool = True) -> Path:
    for i in range(frames):
        write_image(folder / f"frame-{i:06d}.color.png", colour(i))
        write_image(folder / f"frame-{i:06d}.depth.png", depth(1000 + i))
        pose = np.eye(4)
        pose[0, 3] = i
        np.savetxt(folder / f"frame-{i:06d}.pose.txt", pose)
    if intrinsics:
        (folder / "camera-intrinsics.txt").write_text(CAMERA_MATRIX)
    return folder


def write_tum(folder: Path, color_stamps: list[float], depth_stamps: list[float], truth: str = "") -> Path:
    for kind, stamps in (("rgb", color_stamps), ("depth", depth_stamps)):
        lines = ["# freiburg3 made by hand"]
        for i, stamp in enumerate(stamps):
            # Wide enough for the focal length of the published camera.
            size = 8 * WIDTH, 8 * HEIGHT
            write_image(folder / kind / f"{i}.png", colour(i, *size) if kind == "rgb" else depth(5000 + i, *size))
            lines.append(f"{stamp:.6f} {kind}/{i}.png")
        (folder / f"{kind}.txt").write_text("\n".join(lines) + "\n")
    if truth:
        (folder / "groundtruth.txt").write_text(truth)
    return folder


def write_folder(folder: Path, frames: int = 3, camera: dict | None = None) -> Path:
    for i in range(frames):
        write_image(folder / "color" / f"{i:06d}.png", colour(i))
        write_image(folder / "depth" / f"{i:06d}.png", depth(2000 + i))
    if camera is not None:
        (folder / "intrinsics.json").write_text(json.dumps(camera))
    return folder


def camera_json(width: int = WIDTH, height: int = HEIGHT, **more: object) -> dict:
    return {"width": width, "height": height, "fx": 10.0, "fy": 10.0, "cx": 3.5, "cy": 2.5, **more}
