"""transforms.json of instant-ngp and nerfstudio: the camera to world of each image, in OpenGL's axes.

Sources: https://github.com/NVlabs/instant-ngp and https://docs.nerf.studio/quickstart/data_conventions.html
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.trajectory_files.named_images import NamedPose
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_json

KIND = "transforms.json, by names of images"
CV_FROM_GL = np.diag([1.0, -1.0, -1.0, 1.0])  # y up and z backwards there


def read_transforms(path: Path) -> list[NamedPose]:
    """The images of a file with their poses; raises BadInput naming the frame that cannot be read."""
    content = read_json(path, only_finite=False)  # poses that are not finite cost their frames alone
    frames = content.get("frames") if isinstance(content, dict) else None
    if not isinstance(frames, list):
        raise BadInput(f'{path} is JSON without a list "frames": give the transforms.json of nerfstudio or instant-ngp')
    return [_named(frame, f"{path}, frames[{number}]") for number, frame in enumerate(frames)]


def _named(frame: object, place: str) -> NamedPose:
    try:
        name, rows = frame["file_path"], frame["transform_matrix"]  # type: ignore[index]
        matrix = np.array([[float(value) for value in row] for row in rows], dtype=np.float64)
        if not isinstance(name, str):
            raise TypeError("file_path is no text")
    except MALFORMED:
        raise BadInput(f"{place} needs a file_path and a transform_matrix of numbers") from None
    return NamedPose(name, _whole(matrix, place) @ CV_FROM_GL)


def _whole(matrix: Float64Array, place: str) -> Float64Array:
    """The (4, 4) matrix; some programs leave its last row out."""
    if matrix.shape == (3, 4):
        return np.vstack([matrix, (0.0, 0.0, 0.0, 1.0)])
    if matrix.shape != (4, 4):
        raise BadInput(f"{place}: its transform_matrix is not 4x4")
    return matrix
