"""Reader of ScanNet scenes as they are downloaded: one .sens file, or the folder of a scene that holds it."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.readers.scannet.extracted import FRAMES_PER_SECOND, annotated, pinhole, two_cameras
from data_tools.readers.scannet.sens_file import SensHeader, SensIndex, read_header, read_index
from data_tools.recordings.camera import Declared
from data_tools.recordings.images import MAX_FRAME_BYTES, decode_rgb, metres, unusable_frame
from data_tools.recordings.recorded_sequence import ImageSource, RecordedSequence, recorded_sequence
from data_tools.recordings.trajectories import PoseWithNotes, checked_pose
from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.errors import BadInput, UnusableFrame
from razer.files import opened
from razer.geometry import inverse, is_rigid


@dataclass(frozen=True)
class SensImages(ImageSource):
    """The images of a file. Where its end is missing, one more frame stands for all that are lost and says so."""

    path: Path
    header: SensHeader
    index: SensIndex
    stamps: Float64Array

    def __len__(self) -> int:
        return len(self.index.heads) + bool(self.index.cut)

    def stamp(self, index: int) -> float:
        """Seconds."""
        return float(self.stamps[index])

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""
        data = self._data(index, "color")
        if self.header.color_kind != "raw":
            return decode_rgb(data, self._name(index, "colour"))
        width, height = self.header.color_size
        if len(data) != height * width * 3:
            raise UnusableFrame(f"{self._name(index, 'colour')} has {len(data)} bytes, not {width}x{height}x3")
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading; raises UnusableFrame."""
        data, name = self._data(index, "depth"), self._name(index, "depth")
        width, height = self.header.depth_size
        if self.header.depth_kind == "zlib_ushort":
            data = _inflated(data, name, width * height * 2)
        if len(data) != width * height * 2:
            raise UnusableFrame(f"{name} has {len(data)} bytes, not {width}x{height}x2")
        return metres(np.frombuffer(data, "<u2").reshape(height, width), self.header.depth_shift)

    def _data(self, index: int, kind: str) -> bytes:
        if index >= len(self.index.heads):
            raise UnusableFrame(self.index.cut)
        color, depth = self.index.heads[index]["sizes"].tolist()
        at = int(self.index.offsets[index])
        size = color if kind == "color" else depth
        if size > MAX_FRAME_BYTES:
            raise UnusableFrame(f"{self._name(index, kind)} has {size:,} bytes, more than any image")
        with unusable_frame(), opened(self.path) as file:
            file.seek(at if kind == "color" else at + color)
            return file.read(size)

    def _name(self, index: int, kind: str) -> str:
        return f"{self.path.name}, {kind} of frame {index}"


@dataclass(frozen=True)
class SensPoses:
    """The poses in the heads of the frames."""

    source: str
    index: SensIndex

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        if index >= len(self.index.heads):
            raise UnusableFrame(self.index.cut)
        return checked_pose(self.index.heads[index]["pose"].astype(np.float64), f"{self.source}, frame {index}")


def is_sens(path: Path) -> bool:
    """Whether this is a .sens file, or a folder with one of its own name or with only one."""
    return _file(path) is not None


def read_sens(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A .sens file or the folder that holds it, colour brought onto the depth image; raises BadInput.

    The file is gone through once without reading its images. Stamps are those of depth, or number / 30 s where they
    do not increase. A file in which no pose is finite has none."""
    path = _file(folder) or folder
    header = read_header(path)
    index = read_index(path, header)
    if not len(index.heads):
        raise BadInput(f"{path} holds no whole frame of {header.n_frames}: copy or download it again")
    stamps, is_recorded = _stamps(index)
    images = SensImages(path, header, index, stamps)
    has_poses = use_poses and bool(np.isfinite(index.heads["pose"]).all(axis=(1, 2)).any())
    poses = SensPoses(path.name, index) if has_poses else None
    try:
        recorded = _cameras(header)
    except BadInput as error:
        if declared.depth_camera is None:
            raise BadInput(f"{path}: {error}") from None
        recorded = Declared()
    sequence = recorded_sequence(
        path, images, declared.or_else(recorded), poses, depth_scale=header.depth_shift, recorded_stamps=is_recorded
    )
    return annotated(sequence, (path.absolute().parent,), path.stem, range(len(images)))


def _file(path: Path) -> Path | None:
    if path.is_file():
        return path if path.suffix.lower() == ".sens" else None
    files = sorted(path.glob("*.sens"))
    return next((file for file in files if file.stem == path.name), files[0] if len(files) == 1 else None)


def _cameras(header: SensHeader) -> Declared:
    if not (is_rigid(header.color_extrinsic, 1e-3) and is_rigid(header.depth_extrinsic, 1e-3)):
        raise BadInput("its extrinsic matrices are not rigid: give --intrinsics and --depth-to-color")
    depth = pinhole(header.depth_matrix, header.depth_size)
    color = pinhole(header.color_matrix, header.color_size)
    return two_cameras(depth, color, inverse(header.color_extrinsic) @ header.depth_extrinsic)


def _stamps(index: SensIndex) -> tuple[Float64Array, bool]:
    """Seconds for each frame, and for the one that stands for those that are missing; and whether a clock says so."""
    seconds = index.heads["depth_us"].astype(np.float64) / 1e6
    is_recorded = bool((np.diff(seconds) > 0).all())
    if not is_recorded:
        seconds = np.arange(len(seconds)) / FRAMES_PER_SECOND
    return np.append(seconds, seconds[-1]), is_recorded


def _inflated(data: bytes, name: str, expected: int) -> bytes:
    try:
        return zlib.decompressobj().decompress(data, expected + 1)
    except zlib.error:
        raise UnusableFrame(f"{name} is damaged") from None
