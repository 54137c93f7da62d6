"""Camera calibration as it is declared, by the files of a recording or by the user."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import MALFORMED, MissingFile, read_json, read_numbers
from razer.frame import Intrinsics
from razer.geometry import is_rigid

MIN_DEPTH_SCALE = 1e-6  # units per metre, of which one would be a thousand kilometres
_FOCAL_LENGTHS = (0.1, 10.0)  # in widths of the image: from 157 degrees of view to 6
HOW_TO_DECLARE = "--intrinsics fx,fy,cx,cy[,k1,k2,p1,p2,k3] or --intrinsics FILE.json"
GUESS = "guess"  # in place of intrinsics: nobody knows them
_GUESSED_FOCAL_LENGTH = 0.8  # in widths of the image: depth cameras have from 0.58 to 0.95


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera with the distortion k1 k2 p1 p2 k3 of Brown's model (empty = none); size (width,
    height) is that of the images it was calibrated on, None = of whatever images come with it."""

    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if not np.isfinite([self.fx, self.fy, self.cx, self.cy, *self.distortion]).all():
            raise BadInput("intrinsics must be finite numbers")
        if self.fx <= 0 or self.fy <= 0:
            raise BadInput(f"focal lengths must be positive, not {self.fx:g}, {self.fy:g}")
        if len(self.distortion) not in (0, 5):
            raise BadInput(f"distortion needs the five numbers k1,k2,p1,p2,k3, not {len(self.distortion)}")

    def at(self, size: tuple[int, int]) -> Intrinsics:
        """The pinhole part for images of `size`; raises BadInput for one of another aspect, and for focal lengths that
        no lens has."""
        width, height = self.size or size
        declared = Intrinsics(width, height, self.fx, self.fy, self.cx, self.cy)
        if declared.width * size[1] != declared.height * size[0]:
            raise BadInput(
                f"the intrinsics are for {width}x{height} but the images are {size[0]}x{size[1]}: "
                f"correct width and height, or give {HOW_TO_DECLARE}"
            )
        low, high = (share * declared.width for share in _FOCAL_LENGTHS)
        if not (low <= declared.fx <= high and low <= declared.fy <= high):
            raise BadInput(
                f"focal lengths of {self.fx:g}, {self.fy:g} pixels are impossible for images {declared.width} pixels "
                f"wide: correct them, or give {HOW_TO_DECLARE}"
            )
        return declared.resized(*size)


@dataclass(frozen=True, slots=True)
class GuessedCamera(Camera):
    """A camera of which only the size of its images is known: some 64 degrees of view, centred."""

    def at(self, size: tuple[int, int]) -> Intrinsics:
        """The guess for images of `size`."""
        width, height = size
        focal_length = _GUESSED_FOCAL_LENGTH * width
        return Intrinsics(width, height, focal_length, focal_length, (width - 1) / 2, (height - 1) / 2)


@dataclass(frozen=True, slots=True)
class Declared:
    """What is known of a recording beyond its images; None = not declared.

    depth_scale is in units per metre; color_from_depth (4, 4) takes points of the depth camera to the
    colour camera, metres.
    """

    depth_camera: Camera | None = None
    color_camera: Camera | None = None
    depth_scale: float | None = None
    color_from_depth: Float64Array | None = None

    def __post_init__(self) -> None:
        if self.depth_scale is not None and not MIN_DEPTH_SCALE <= self.depth_scale < np.inf:
            raise BadInput(
                f"the depth scale must be positive units per metre, at least {MIN_DEPTH_SCALE:g}, not "
                f"{self.depth_scale:g}: 1000 where depth is in millimetres, 1 where it is in metres"
            )

    def or_else(self, fallback: Declared) -> Declared:
        """These declarations, with the gaps filled from `fallback`; a camera brings its own partner."""
        cameras = self if self.depth_camera else fallback
        scale = fallback.depth_scale if self.depth_scale is None else self.depth_scale
        color_from_depth = fallback.color_from_depth if self.color_from_depth is None else self.color_from_depth
        return Declared(cameras.depth_camera, cameras.color_camera, scale, color_from_depth)


def declare(
    camera: str | None = None, depth_scale: float | None = None, depth_to_color: Path | None = None
) -> Declared:
    """What the user says on the command line: `camera` is fx,fy,cx,cy[,k1,k2,p1,p2,k3], a JSON file or guess;
    raises BadInput."""
    declared = Declared() if camera is None else _parse_camera(camera)
    if depth_scale is not None:
        declared = replace(declared, depth_scale=depth_scale)
    if depth_to_color is not None:
        declared = replace(declared, color_from_depth=_read_extrinsic(depth_to_color))
    return declared


def read_camera_file(path: Path) -> Declared:
    """An intrinsics.json: width, height, fx, fy, cx, cy, optionally distortion [5], depth_scale (units per
    metre), and "color" with a camera of its own; raises BadInput naming the file."""
    try:
        content = read_json(path)
    except MissingFile:
        raise BadInput(f"{path} does not exist; give {HOW_TO_DECLARE}") from None
    if not isinstance(content, dict):
        raise BadInput(f"{path} must be a JSON object with width, height, fx, fy, cx, cy as numbers")
    try:
        color = content.get("color")
        return Declared(_camera_from(content), _camera_from(color) if color else None, content.get("depth_scale"))
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    except MALFORMED as error:
        raise BadInput(
            f"{path} must be JSON with width, height, fx, fy, cx, cy as numbers (problem: {error})"
        ) from error


def read_camera_matrix(path: Path) -> Camera:
    """A text file with a 3x3 camera matrix, as 7-Scenes tools write it; raises BadInput naming the file."""
    what = f"a 3x3 camera matrix; or give {HOW_TO_DECLARE}"
    numbers = read_numbers(path, what)
    if numbers.size != 9:
        raise BadInput(f"{path} must hold {what}")
    fx, _, cx, _, fy, cy, *_ = numbers.tolist()
    try:
        return Camera(fx, fy, cx, cy)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _camera_from(content: Mapping[str, Any]) -> Camera:
    fx, fy, cx, cy = (float(content[name]) for name in ("fx", "fy", "cx", "cy"))
    distortion = tuple(float(value) for value in content.get("distortion", ()))
    return Camera(fx, fy, cx, cy, distortion, (_side_px(content, "width"), _side_px(content, "height")))


def _side_px(content: Mapping[str, Any], name: str) -> int:
    side = float(content[name])
    if not side.is_integer():
        raise BadInput(f"{name} {side:g} is no whole number of pixels")
    return int(side)


def _parse_camera(text: str) -> Declared:
    if text == GUESS:
        return Declared(GuessedCamera(1.0, 1.0, 0.0, 0.0))
    if text.lower().endswith(".json"):
        return read_camera_file(Path(text))
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (4, 9):
        raise BadInput(f"intrinsics '{text}' are not understood: give {HOW_TO_DECLARE}")
    fx, fy, cx, cy, *distortion = numbers
    try:
        return Declared(Camera(fx, fy, cx, cy, tuple(distortion)))
    except BadInput as error:
        raise BadInput(f"intrinsics '{text}': {error}; give {HOW_TO_DECLARE}") from None


def _read_extrinsic(path: Path) -> Float64Array:
    what = "a rigid 4x4 matrix that takes depth-camera metres to colour-camera"
    try:
        numbers = read_numbers(path, what)
    except MissingFile:
        raise BadInput(f"{path} does not exist: give --depth-to-color a file with a 4x4 matrix") from None
    if numbers.size != 16 or not is_rigid(matrix := numbers.reshape(4, 4), tolerance=1e-3):
        raise BadInput(f"{path} must hold {what}")
    return matrix
