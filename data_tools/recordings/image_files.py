"""Image files as an image source: one colour and one depth file a frame, as all folder layouts have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from data_tools.recordings.camera import HOW_TO_DECLARE, Declared
from data_tools.recordings.images import read_depth, read_ids, read_parts, read_rgb, short_name
from data_tools.recordings.recorded_sequence import ImageSource, RecordedSequence, recorded_sequence
from data_tools.recordings.trajectories import PoseSource
from razer.arrays import Float32Array, Int32Array, Uint8Array
from razer.errors import BadInput


@dataclass(frozen=True, slots=True)
class ImagePaths:
    """The files of one frame; ids and parts are images of instance ids, and of their parts, on the depth grid; stamp in
    seconds."""

    color: Path
    depth: Path
    stamp: float
    ids: Path | None = None
    parts: Path | None = None


@dataclass(frozen=True, slots=True)
class ImageFiles(ImageSource):
    """Image files, those of one frame after the other; depth_scale in units per metre."""

    paths: tuple[ImagePaths, ...]
    depth_scale: float

    def __len__(self) -> int:
        return len(self.paths)

    def stamp(self, index: int) -> float:
        """Seconds."""
        return self.paths[index].stamp

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""
        return read_rgb(self.paths[index].color)

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading; raises UnusableFrame."""
        return read_depth(self.paths[index].depth, self.depth_scale)

    def instance_ids(self, index: int) -> Int32Array | None:
        """(h, w), 0 = nobody's; None where there is no file of them; raises UnusableFrame."""
        path = self.paths[index].ids
        return None if path is None else read_ids(path)

    def part_ids(self, index: int) -> Uint8Array | None:
        """(h, w), numbers within each instance from 1, 0 = of no part; None where there is no file of them; raises
        UnusableFrame."""
        path = self.paths[index].parts
        return None if path is None else read_parts(path)

    def label(self, index: int, kind: str) -> str:
        """The name of the file."""
        paths = self.paths[index]
        path = {"colour": paths.color, "depth": paths.depth, "parts": paths.parts}.get(kind, paths.ids)
        return kind if path is None else short_name(path)

    def color_file(self, index: int) -> str:
        """The path of the colour image."""
        return self.paths[index].color.as_posix()


def file_sequence(
    folder: Path,
    paths: tuple[ImagePaths, ...],
    declared: Declared,
    pose_of: PoseSource | None,
    class_names: Mapping[int, str] | None = None,
    *,
    recorded_stamps: bool = False,
) -> RecordedSequence:
    """The sequence of image files.

    Args:
        folder: the recording, for its name and for messages.
        paths: the files of each frame.
        declared: the cameras, the scale of depth, and how colour lies to depth.
        pose_of: where the poses come from; None = there are none.
        class_names: the class of each instance id.
        recorded_stamps: whether stamps are those of a clock, and not made up by the reader.

    Raises:
        BadInput: where the camera or the scale of depth is unknown, colour and depth do not fit together, or no
            image can be read.
    """
    if declared.depth_scale is None:
        raise BadInput(f"{folder} does not say what camera took it: give {HOW_TO_DECLARE}, and --depth-scale")
    images = ImageFiles(paths, declared.depth_scale)
    return recorded_sequence(
        folder,
        images,
        declared,
        pose_of,
        name=folder.name,
        depth_scale=declared.depth_scale,
        class_names=class_names,
        recorded_stamps=recorded_stamps,
    )
