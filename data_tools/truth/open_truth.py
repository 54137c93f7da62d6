"""Registry of ground-truth layouts: the truth of a scene is read from whatever layout a folder has."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.replica_truth import is_replica_truth, read_replica_truth
from data_tools.truth.scannet_truth import is_scannet_truth, read_scannet_truth
from data_tools.truth.scenenn_truth import is_scenenn_truth, read_scenenn_truth
from data_tools.truth.truth_folder import read_truth
from razer.errors import BadInput
from razer.files import plain_os_errors


@dataclass(frozen=True, slots=True)
class TruthLayout:
    """How a layout is recognised, and read with a vocabulary and, where a folder holds several, a scene; None for the
    dataset's own vocabulary and the only scene."""

    matches: Callable[[Path], bool]
    read: Callable[[Path, str | None, str | None], GroundTruth]


def _own_folder(folder: Path) -> Path | None:
    places = (folder, folder / "truth")
    return next((p for p in places if (p / "mesh.ply").is_file() and (p / "classes.json").is_file()), None)


def _read_own(folder: Path, vocabulary: str | None, scene: str | None) -> GroundTruth:
    return read_truth(_own_folder(folder) or folder)


def _read_scenenn(folder: Path, vocabulary: str | None, scene: str | None) -> GroundTruth:
    return read_scenenn_truth(folder, vocabulary or "nyu40")


def _read_scannet(folder: Path, vocabulary: str | None, scene: str | None) -> GroundTruth:
    named = scene if scene and is_scannet_truth(folder, scene) else None
    return read_scannet_truth(folder, vocabulary or "scannet200", scene=named)


def _read_replica(folder: Path, vocabulary: str | None, scene: str | None) -> GroundTruth:
    return read_replica_truth(folder, vocabulary)


LAYOUTS = {
    "own": TruthLayout(lambda folder: _own_folder(folder) is not None, _read_own),
    "scannet": TruthLayout(is_scannet_truth, _read_scannet),
    "replica": TruthLayout(is_replica_truth, _read_replica),
    "scenenn": TruthLayout(is_scenenn_truth, _read_scenenn),
}


def has_truth(folder: Path) -> bool:
    """Whether a folder holds a truth in one of LAYOUTS."""
    return any(layout.matches(folder) for layout in LAYOUTS.values())


def open_truth(folder: Path, *, vocabulary: str | None = None, scene: str | None = None) -> GroundTruth:
    """The truth that a folder of one of LAYOUTS holds; raises BadInput.

    vocabulary: whose classes a dataset's names are turned into, None = those it is annotated with (nyu40 for SceneNN,
    scannet200 for ScanNet); scene: which one, where the folder holds several, as folders or as files of that name
    (Replica's room_0 is read as room0 too)."""
    folder = Path(folder).absolute()
    with plain_os_errors(folder):
        if not folder.is_dir():
            raise BadInput(f"{folder} is not a folder: give the folder with the ground truth")
        folder = folder if scene is None else _scene_folder(folder, scene)
        for layout in LAYOUTS.values():
            if layout.matches(folder):
                return layout.read(folder, vocabulary, scene)
    raise BadInput(f"{folder} holds no ground truth in a known layout: {', '.join(LAYOUTS)}")


def _scene_folder(folder: Path, scene: str) -> Path:
    """The folder of a scene among those of others; the given one where there is none of its name."""
    names = (scene, re.sub(r"(?<=[a-z])(?=\d+$)", "_", scene))
    return next((place for name in names if (place := folder / name).is_dir()), folder)
