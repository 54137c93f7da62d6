"""Reader of ScanNet scenes that SensReader extracted: color/0.jpg, depth/0.png, pose/0.txt and intrinsic/.

Depth is in millimetres, poses are world_from_camera of the depth camera, -inf where the reconstruction lost track.
Colour has 1296x968 pixels, depth 640x480; each has its 4x4 intrinsic matrix, and an extrinsic one that leads from it
to a base. The preview scannet_frames_25k has intrinsics_color.txt beside the images instead. Annotated instances may
lie beside them, on the grid of colour. Source:
https://github.com/ScanNet/ScanNet/tree/master/SensReader
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from data_tools.readers.scannet.instance_images import find_instance_images, object_names
from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.images import read_rgb, size_of
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.rgbd_alignment import Size
from data_tools.recordings.trajectories import PoseFiles
from razer.arrays import Float64Array
from razer.errors import BadInput, UnusableFrame
from razer.files import read_numbers
from razer.frame import Intrinsics
from razer.geometry import inverse, is_rigid

MILLIMETRES = 1000.0
FRAMES_PER_SECOND = 30.0
COLOR_SIZE = (1296, 968)
_INTRINSICS = ("intrinsic/intrinsic_{}.txt", "intrinsic_{}.txt", "intrinsics_{}.txt")
_EXTRINSICS = ("intrinsic/extrinsic_{}.txt", "extrinsic_{}.txt")
_SAME_SIZE = 0.2  # share of its width by which an image may differ from twice its principal point


def is_scannet(folder: Path) -> bool:
    """Whether there are color/ and depth/ with the intrinsic matrix of the depth camera, here or in frames/."""
    return _frames(folder) is not None


def read_scannet(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A scene in this layout, colour brought onto the depth image; raises BadInput. Stamps are number / 30 s."""
    frames = _frames(folder) or folder
    colors, depths = _numbered(frames / "color"), _numbered(frames / "depth")
    numbers = sorted(colors.keys() | depths.keys())
    paths = tuple(
        ImagePaths(
            colors.get(n, frames / "color" / f"{n}.jpg"),
            depths.get(n, frames / "depth" / f"{n}.png"),
            n / FRAMES_PER_SECOND,
        )
        for n in numbers
    )
    poses = None
    if use_poses and (frames / "pose").is_dir():
        names = [(colors.get(n) or depths[n]).stem for n in numbers]
        poses = PoseFiles(tuple(frames / "pose" / f"{name}.txt" for name in names))
    if declared.depth_camera is None:
        declared = declared.or_else(_cameras(frames, paths, declared))
    sequence = file_sequence(folder, paths, declared.or_else(Declared(depth_scale=MILLIMETRES)), poses)
    return annotated(sequence, (frames, folder), folder.absolute().name, numbers)


def annotated(
    sequence: RecordedSequence, places: Sequence[Path], scene: str, numbers: Sequence[int]
) -> RecordedSequence:
    """The sequence with the annotated instances of its frames, where one of some folders has them, the last of which
    has the scene's list of objects. Raises BadInput for a damaged one."""
    images = find_instance_images(places, scene, numbers)
    if images is None:
        return sequence
    return replace(sequence, color_ids=images, class_names=object_names(places[-1].absolute(), scene))


def two_cameras(depth: Camera, color: Camera, color_from_depth: Float64Array) -> Declared:
    """What a scene declares; where both cameras are one and the same, colour needs no warping."""
    if depth == color and np.array_equal(color_from_depth, np.eye(4)):
        return Declared(depth)
    return Declared(depth, color, color_from_depth=color_from_depth)


def pinhole(matrix: Float64Array, size: Size | None = None) -> Camera:
    """The camera of a 3x3 or 4x4 intrinsic matrix; raises BadInput."""
    fx, fy, cx, cy = matrix[[0, 1, 0, 1], [0, 1, 2, 2]].tolist()
    return Camera(fx, fy, cx, cy, size=size)


def _frames(folder: Path) -> Path | None:
    for place in (folder, folder / "frames"):
        images = all((place / kind).is_dir() for kind in ("color", "depth"))
        if images and _matrix_file(place, _INTRINSICS, "depth"):
            return place
    return None


def _numbered(folder: Path) -> dict[int, Path]:
    return {int(path.stem): path for path in sorted(folder.iterdir()) if path.stem.isdecimal()}


def _cameras(frames: Path, paths: tuple[ImagePaths, ...], declared: Declared) -> Declared:
    """The cameras of the matrices beside the images, and how colour lies to depth."""
    depth = _pinhole_in(_matrix_file(frames, _INTRINSICS, "depth") or frames)
    file = _matrix_file(frames, _INTRINSICS, "color")
    if file is None:
        return Declared(depth)
    color = _fitted(_pinhole_in(file), paths)
    if declared.color_from_depth is not None:
        return Declared(depth, color)
    return two_cameras(depth, color, inverse(_extrinsic(frames, "color")) @ _extrinsic(frames, "depth"))


def _pinhole_in(file: Path) -> Camera:
    try:
        return pinhole(_matrix(file))
    except BadInput as error:
        raise error if str(file) in str(error) else BadInput(f"{file}: {error}") from None


def _fitted(camera: Camera, paths: tuple[ImagePaths, ...]) -> Camera:
    """The colour camera at the size of the images: some extract them smaller, and leave the matrix as it was."""
    size = _first_size(paths)
    if size is None or abs(2 * camera.cx + 1 - size[0]) <= _SAME_SIZE * size[0]:
        return camera
    small = Intrinsics(*COLOR_SIZE, camera.fx, camera.fy, camera.cx, camera.cy).resized(*size)
    return Camera(small.fx, small.fy, small.cx, small.cy)


def _first_size(paths: tuple[ImagePaths, ...]) -> Size | None:
    for each in paths:
        try:
            return size_of(read_rgb(each.color))
        except UnusableFrame:
            continue
    return None


def _extrinsic(frames: Path, kind: str) -> Float64Array:
    file = _matrix_file(frames, _EXTRINSICS, kind)
    matrix = np.eye(4) if file is None else _matrix(file)
    if not is_rigid(matrix, tolerance=1e-3):
        raise BadInput(f"{file} must hold a rigid 4x4 matrix; or give --depth-to-color FILE")
    return matrix


def _matrix_file(frames: Path, places: tuple[str, ...], kind: str) -> Path | None:
    return next((path for place in places if (path := frames / place.format(kind)).is_file()), None)


def _matrix(path: Path) -> Float64Array:
    what = "a 4x4 matrix, row by row; or give --intrinsics fx,fy,cx,cy"
    numbers = read_numbers(path, what)
    side = {9: 3, 16: 4}.get(numbers.size)
    if side is None:
        raise BadInput(f"{path} must hold {what}")
    return numbers.reshape(side, side)
