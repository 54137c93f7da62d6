"""Registry of dataset readers: a folder is recognised by its layout and opened as an RGB-D sequence."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from data_tools.recordings.camera import Declared, declare
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.files import plain_os_errors
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


Reader = Callable[[Path, Declared, bool], RgbdSequence]
"""A reader of one layout: of the folder, what the user declares of the cameras, and whether to read poses."""


def open_sequence(
    folder: str | Path,
    *,
    reader: str | Reader | None = None,
    camera: str | None = None,
    depth_scale: float | None = None,
    depth_to_color: Path | None = None,
    use_poses: bool = True,
    poses_from: Path | None = None,
    trust: Trust | None = None,
) -> RgbdSequence:
    """The recording in a folder, a .sens, a .r3d or a .bag.

    Args:
        folder: the recording.
        reader: a name in READERS; a function of your own; or, where `trust` covers it, its name "module:function".
            None = the layout is recognised.
        camera: fx,fy,cx,cy[,k1,k2,p1,p2,k3] in pixels or a JSON file, instead of what the folder says.
        depth_scale: units per metre, instead of what the folder says.
        depth_to_color: a file with the 4x4 matrix from the depth to the colour camera, metres.
        use_poses: False leaves the poses unread.
        poses_from: a file with other poses: TUM, KITTI, COLMAP's images.txt, transforms.json.
        trust: which outside code may be loaded by name; None = none.

    Raises:
        BadInput: where there is no recording, or it cannot be read.
    """
    folder = Path(folder).absolute()
    with plain_os_errors(folder):
        if not folder.exists():
            raise BadInput(f"{folder} does not exist: give a folder with a recording")
        if not callable(reader):
            _require_layout(folder, reader)
        declared = declare(camera, depth_scale, depth_to_color)
        own_poses = use_poses and poses_from is None
        sequence: RgbdSequence
        if callable(reader):
            sequence = reader(folder, declared, own_poses)
        else:
            options = {"folder": folder, "declared": declared, "use_poses": own_poses}
            sequence = load("reader", reader or recognise(folder), READERS, options, trust=trust)
        return sequence if poses_from is None else _posed_by(sequence, poses_from)


def _posed_by(sequence: RgbdSequence, path: Path) -> RgbdSequence:
    from data_tools.trajectory_files.posed_sequence import posed_by  # brings OpenCV along

    return posed_by(sequence, path)


def recognise(folder: Path) -> str:
    """The name in READERS of a folder's layout; raises BadInput where it has none of them."""
    if layout := _layout(folder):
        return layout
    if not any(folder.iterdir()):
        raise BadInput(f"{folder} is empty: give a folder with a recording")
    inside = [path.name for path in sorted(folder.iterdir()) if path.is_dir() and _layout(path)]
    hint = f"; there are recordings inside it: {', '.join(inside[:5])}" if inside else ""
    raise BadInput(
        f"{folder} has no known layout ({', '.join(READERS)}): at the least it needs the folders color and depth, "
        f"and intrinsics.json{hint}"
    )


def _require_layout(folder: Path, reader: str | None) -> None:
    """Raise BadInput for a file of no known layout, and for a folder that has not the layout of the named reader."""
    if not folder.is_dir() and reader is None and not _layout(folder):
        raise BadInput(f"{folder} is not a folder: give the folder that holds the recording, a .sens, a .r3d or a .bag")
    if reader in _LAYOUTS and not _matches(reader, folder):
        raise BadInput(f"{folder} has not the layout that reader '{reader}' reads: leave --reader away")


def _layout(folder: Path) -> str | None:
    return next((name for name in _LAYOUTS if _matches(name, folder)), None)


def _matches(layout: str, folder: Path) -> bool:
    module, function = _LAYOUTS[layout]
    return bool(getattr(import_module(module), f"is_{function}")(folder))
