"""Matching of poses that files give by the name of an image."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from data_tools.trajectory_files.frame_poses import FramePoses
from razer.arrays import Float64Array
from razer.errors import BadInput

_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".ppm")


@dataclass(frozen=True, slots=True)
class NamedPose:
    """A world_from_camera (4, 4) in OpenCV's axes, of the image of that name."""

    image: str
    pose: Float64Array


def poses_by_name(path: Path, named: Sequence[NamedPose], colors: Sequence[str]) -> FramePoses:
    """Poses for the frames whose colour images have those names, but for folders and endings; raises BadInput where
    there is none, and where two images have one name.

    Args:
        path: the file, for messages.
        named: its poses.
        colors: the file of colour of each frame, '' for those that have none.
    """
    if not any(colors):
        raise BadInput(
            f"{path} gives poses by the names of images, which this recording has none of: "
            "write it out with `razer convert` first"
        )
    by_name = _by_name(path, named, {PurePosixPath(color).parent.name for color in colors})
    poses = {frame: by_name[name] for frame, color in enumerate(colors) if (name := stem(color)) in by_name}
    if not poses:
        examples = f"'{named[0].image}' there, '{PurePosixPath(colors[0]).name}' here" if named else "it holds no pose"
        raise BadInput(f"{path}: none of its images has the name of one of the recording ({examples})")
    return FramePoses(path.name, poses)


def _by_name(path: Path, named: Sequence[NamedPose], folders: set[str]) -> Mapping[str, Float64Array]:
    """Poses by the names of images; of several cameras' images of one name those in the folder of colour."""
    chosen: dict[str, NamedPose] = {}
    for one in named:
        name = stem(one.image)
        before = chosen.get(name)
        if before is None or (_folder(one) in folders and _folder(before) not in folders):
            chosen[name] = one
        elif (_folder(one) in folders) == (_folder(before) in folders):
            raise BadInput(f"{path} has two poses for one image, '{before.image}' and '{one.image}': leave one out")
    return {name: one.pose for name, one in chosen.items()}


def _folder(one: NamedPose) -> str:
    return _path(one.image).parent.name


def stem(name: str) -> str:
    """The name of an image without folders and without the ending of an image: what else has a dot stays whole."""
    path = _path(name)
    return path.stem if path.suffix.lower() in _SUFFIXES else path.name


def _path(name: str) -> PurePosixPath:
    return PurePosixPath(name.replace("\\", "/"))
