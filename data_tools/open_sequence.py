"""What every recording looks like to the program, and how a folder is opened as one."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from data_tools.readers.folder import is_folder
from data_tools.readers.icl_nuim import is_icl_nuim
from data_tools.readers.record3d import is_record3d
from data_tools.readers.redwood import is_redwood
from data_tools.readers.replica import is_replica
from data_tools.readers.ros.bag import is_ros_bag
from data_tools.readers.scannet.extracted import is_scannet
from data_tools.readers.scannet.sens import is_sens
from data_tools.readers.scenenn import is_scenenn
from data_tools.readers.seven_scenes import is_seven_scenes
from data_tools.readers.tum import is_tum
from data_tools.recordings.camera import declare
from razer.frame import BadInput, Frame, Intrinsics
from razer.plugins import Trust, load

READERS = {
    "7scenes": "data_tools.readers.seven_scenes:read_seven_scenes",
    "scannet": "data_tools.readers.scannet.extracted:read_scannet",
    "sens": "data_tools.readers.scannet.sens:read_sens",
    "replica": "data_tools.readers.replica:read_replica",
    "scenenn": "data_tools.readers.scenenn:read_scenenn",
    "icl-nuim": "data_tools.readers.icl_nuim:read_icl_nuim",
    "record3d": "data_tools.readers.record3d:read_record3d",
    "ros": "data_tools.readers.ros.bag:read_ros_bag",
    "tum": "data_tools.readers.tum:read_tum",
    "redwood": "data_tools.readers.redwood:read_redwood",
    "folder": "data_tools.readers.folder:read_folder",
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
