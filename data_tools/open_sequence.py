"""The registry of readers: a folder is recognised by its layout and opened as a sequence of frames."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from data_tools.recordings.camera import declare
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.plugins import Trust, load

# By layout, in the order in which they are tried: the module with a function is_LAYOUT(folder) -> bool, and
# read_LAYOUT(folder, declared, use_poses) -> RgbdSequence. A reader is imported when a folder is looked at.
_LAYOUTS = {
    "7scenes": ("data_tools.readers.seven_scenes", "seven_scenes"),
    "scannet": ("data_tools.readers.scannet.extracted", "scannet"),
    "sens": ("data_tools.readers.scannet.sens", "sens"),
    "replica": ("data_tools.readers.replica", "replica"),
    "scenenn": ("data_tools.readers.scenenn", "scenenn"),
    "icl-nuim": ("data_tools.readers.icl_nuim", "icl_nuim"),
    "record3d": ("data_tools.readers.record3d", "record3d"),
    "ros": ("data_tools.readers.ros.bag", "ros_bag"),
    "tum": ("data_tools.readers.tum", "tum"),
    "redwood": ("data_tools.readers.redwood", "redwood"),
    "folder": ("data_tools.readers.folder", "folder"),
}
READERS = {name: f"{module}:read_{function}" for name, (module, function) in _LAYOUTS.items()}


def open_sequence(
    folder: Path,
    *,
    reader: str | None = None,
    camera: str | None = None,
    depth_scale: float | None = None,
    depth_to_color: Path | None = None,
    use_poses: bool = True,
    trust: Trust | None = None,
) -> RgbdSequence:
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
    if reader in _LAYOUTS and not _matches(reader, folder):
        raise BadInput(f"{folder} has not the layout that reader '{reader}' reads: leave --reader away")
    declared = declare(camera, depth_scale, depth_to_color)
    options = {"folder": folder, "declared": declared, "use_poses": use_poses}
    sequence: RgbdSequence = load("reader", reader or recognise(folder), READERS, options, trust=trust)
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
    return next((name for name in _LAYOUTS if _matches(name, folder)), None)


def _matches(layout: str, folder: Path) -> bool:
    module, function = _LAYOUTS[layout]
    return bool(getattr(import_module(module), f"is_{function}")(folder))
