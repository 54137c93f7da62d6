"""Reader of ICL-NUIM, in its version that looks like TUM RGB-D: rgb/, depth/, associations.txt, *.gt.freiburg.

Images and poses share one count of frames; poses begin at 1, so that image 0 has none. The published camera has a
negative fy: its y axis points up, and poses are written for it. Mirroring y on both sides, F T F with F = diag(1,
-1, 1, 1), gives the same pixels a positive fy and the world a right hand. Source:
https://www.doc.ic.ac.uk/~ahanda/VaFRIC/iclnuim.html
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.images import IMAGE_SUFFIXES
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.trajectories import NearestPoses, PoseWithNotes, read_trajectory
from razer.errors import BadInput
from razer.files import read_lines

DEPTH_SCALE = 5000.0
FRAMES_PER_SECOND = 30.0
CAMERA = Camera(481.2, 480.0, 319.5, 239.5, size=(640, 480))
_MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])
_FOLDER_NAME = re.compile(r"(living_?room|office_?room)?.*traj\d.*frei_png", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class MirroredPoses:
    """Poses of a camera whose y axis points up, for one whose y axis points down."""

    poses: NearestPoses

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        pose, notes = self.poses(index)
        return _MIRROR @ pose @ _MIRROR, notes


def is_icl_nuim(folder: Path) -> bool:
    """Whether there are rgb/ and depth/ with ground truth under this dataset's name, or a folder it is named by."""
    if not ((folder / "rgb").is_dir() and (folder / "depth").is_dir()):
        return False
    named = _FOLDER_NAME.fullmatch(folder.name) and (folder / "associations.txt").is_file()
    return bool(named) or any(folder.glob("*.gt.freiburg"))


def read_icl_nuim(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: depth in 1/5000 m, poses world_from_camera with a mirrored y; raises BadInput."""
    rows = _associations(folder)
    counted = all(stamp == int(stamp) for stamp, _, _ in rows)
    seconds = 1 / FRAMES_PER_SECOND if counted else 1.0
    paths = tuple(ImagePaths(folder / color, folder / depth, stamp * seconds) for stamp, color, depth in rows)
    truth = next(iter(sorted(folder.glob("*.gt.freiburg"))), None) if use_poses else None
    poses = None
    if truth:
        poses = MirroredPoses(NearestPoses(read_trajectory(truth), tuple(stamp for stamp, _, _ in rows)))
    defaults = Declared(CAMERA, depth_scale=DEPTH_SCALE)
    return file_sequence(folder, paths, declared.or_else(defaults), poses, recorded_stamps=not counted)


def _associations(folder: Path) -> list[tuple[float, str, str]]:
    """(stamp of depth, colour file, depth file) of each frame; raises BadInput."""
    path = folder / "associations.txt"
    if not path.is_file():
        return _same_names(folder)
    rows = []
    for number, line in enumerate(read_lines(path), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            rows.append(_association(line))
        except (ValueError, KeyError):
            raise BadInput(f"{path}, line {number}: expected `n depth/n.png n rgb/n.png`, got '{line}'") from None
    return rows


def _association(line: str) -> tuple[float, str, str]:
    """(stamp of depth, colour file, depth file) of a line; raises ValueError or KeyError."""
    first, a, second, b = line.split()
    stamps = {a.split("/")[0]: float(first), b.split("/")[0]: float(second)}
    files = {a.split("/")[0]: a, b.split("/")[0]: b}
    return stamps["depth"], files["rgb"], files["depth"]


def _same_names(folder: Path) -> list[tuple[float, str, str]]:
    numbers = {
        int(path.stem)
        for kind in ("rgb", "depth")
        for path in (folder / kind).iterdir()
        if path.stem.isdecimal() and path.suffix.lower() in IMAGE_SUFFIXES
    }
    return [(float(n), f"rgb/{n}.png", f"depth/{n}.png") for n in sorted(numbers)]
