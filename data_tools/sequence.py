"""What every recording looks like to the program, and how a folder is opened as one."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from data_tools.camera import declare
from data_tools.formats.folder import is_folder
from data_tools.formats.icl_nuim import is_icl_nuim
from data_tools.formats.record3d import is_record3d
from data_tools.formats.redwood import is_redwood
from data_tools.formats.replica import is_replica
from data_tools.formats.ros_bag import is_ros_bag
from data_tools.formats.scannet import is_scannet
from data_tools.formats.scenenn import is_scenenn
from data_tools.formats.sens import is_sens
from data_tools.formats.seven_scenes import is_seven_scenes
from data_tools.formats.tum import is_tum
from razer.frame import BadInput, Frame, Intrinsics
from razer.plugins import Trust, load

READERS = {
    "7scenes": "data_tools.formats.seven_scenes:read_seven_scenes",
    "scannet": "data_tools.formats.scannet:read_scannet",
    "sens": "data_tools.formats.sens:read_sens",
    "replica": "data_tools.formats.replica:read_replica",
    "scenenn": "data_tools.formats.scenenn:read_scenenn",
    "icl-nuim": "data_tools.formats.icl_nuim:read_icl_nuim",
    "record3d": "data_tools.formats.record3d:read_record3d",
    "ros": "data_tools.formats.ros_bag:read_ros_bag",
    "tum": "data_tools.formats.tum:read_tum",
    "redwood": "data_tools.formats.redwood:read_redwood",
    "folder": "data_tools.formats.folder:read_folder",
}
_RECOGNISERS = {
    "7scenes": is_seven_scenes,
    "scannet": is_scannet,
    "sens": is_sens,
    "replica": is_replica,
    "scenenn": is_scenenn,
    "icl-nuim": is_icl_nuim,
    "record3d": is_record3d,
    "ros": is_ros_bag,
    "tum": is_tum,
    "redwood": is_redwood,
    "folder": is_folder,
}


class Sequence(Protocol):
    """A recording, read lazily and in any order."""

    @property
    def name(self) -> str:
        """What to call the recording."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""

    @property
    def depth_scale(self) -> float:
        """Declared depth units per metre of the files; 1 where depth is made in metres."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""


def open_sequence(
    folder: Path,
    *,
    reader: str | None = None,
    camera: str | None = None,
    depth_scale: float | None = None,
    depth_to_color: Path | None = None,
    use_poses: bool = True,
    trust: Trust | None = None,
) -> Sequence:
    """The recording in a folder; raises BadInput.

    reader: a name in READERS or, where `trust` covers it, "module:function"; None = recognised. camera:
    fx,fy,cx,cy[,k1,k2,p1,p2,k3] or a JSON file; depth_scale: units per metre; depth_to_color: a file with the 4x4
    matrix from the depth to the colour camera, metres; each overrides what the folder says. use_poses=False leaves
    poses unread.
    """
    folder = Path(folder).absolute()
    if not folder.exists():
        raise BadInput(f"{folder} does not exist: give a folder with a recording")
    if not folder.is_dir() and reader is None and not _layout(folder):
        raise BadInput(f"{folder} is not a folder: give the folder that holds the recording, a .sens, a .r3d or a .bag")
    if reader in _RECOGNISERS and not _RECOGNISERS[reader](folder):
        raise BadInput(f"{folder} has not the layout that reader '{reader}' reads: leave --reader away")
    declared = declare(camera, depth_scale, depth_to_color)
    options = {"folder": folder, "declared": declared, "use_poses": use_poses}
    sequence: Sequence = load("reader", reader or recognise(folder), READERS, options, trust=trust)
    return sequence


def recognise(folder: Path) -> str:
    """The name in READERS of a folder's layout; raises BadInput where it has none of them."""
    if found := _layout(folder):
        return found
    if not any(folder.iterdir()):
        raise BadInput(f"{folder} is empty: give a folder with a recording")
    inside = [path.name for path in sorted(folder.iterdir()) if path.is_dir() and _layout(path)]
    hint = f"; there are recordings inside it: {', '.join(inside[:5])}" if inside else ""
    raise BadInput(
        f"{folder} has no known layout ({', '.join(READERS)}): at the least it needs the folders color and depth, "
        f"and intrinsics.json{hint}"
    )


def _layout(folder: Path) -> str | None:
    return next((name for name, matches in _RECOGNISERS.items() if matches(folder)), None)
