"""What is true of a scene, read from whatever layout a folder keeps it in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.scenenn_truth import is_scenenn_truth, read_scenenn_truth
from data_tools.truth.truth_folder import read_truth
from razer.frame import BadInput


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


LAYOUTS = {
    "own": TruthLayout(lambda folder: _own_folder(folder) is not None, _read_own),
    "scenenn": TruthLayout(is_scenenn_truth, _read_scenenn),
}


def has_truth(folder: Path) -> bool:
    """Whether a folder holds a truth in one of LAYOUTS."""
    return any(layout.matches(folder) for layout in LAYOUTS.values())


def open_truth(folder: Path, *, vocabulary: str | None = None, scene: str | None = None) -> GroundTruth:
    """The truth that a folder of one of LAYOUTS holds; raises BadInput.

    vocabulary: whose classes a dataset's names are turned into, None = those it is annotated with (nyu40 for SceneNN);
    scene: which one, where the folder holds several."""
    folder = Path(folder).absolute()
    if not folder.is_dir():
        raise BadInput(f"{folder} is not a folder: give the folder with the ground truth")
    for layout in LAYOUTS.values():
        if layout.matches(folder):
            return layout.read(folder, vocabulary, scene)
    raise BadInput(f"{folder} holds no ground truth in a known layout: {', '.join(LAYOUTS)}")
