"""The folder of a comparison: metrics, plots and a Rerun recording, each replaced atomically."""

from __future__ import annotations

from json import dumps
from pathlib import Path

from app.comparison import plots
from app.comparison.compare_runs import Comparison
from app.comparison.recording import write_recording
from app.comparison.sheet import sheet
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content, replace_file

NUMBERS = "compare.json"
RECORDING = "compare.rrd"
SHEET = "compare.png"
CONTENTS = {
    SHEET: "the sheet: both paths, where the maps differ, and what that comes to",
    NUMBERS: "all numbers",
    "trajectories.png": "both paths",
    "errors.png": "differences of poses over time",
    "instances.png": "the instances of both, matched",
    RECORDING: "both maps in one frame, for Rerun",
}
PLOTS = {"trajectories.png": plots.trajectories, "errors.png": plots.errors, "instances.png": plots.instances}


def check_folder(folder: Path) -> None:
    """Raise BadInput, before any work is done, if something else lies where the folder should be."""
    ancestor = next((path for path in (folder, *folder.absolute().parents) if path.exists()), folder)
    if ancestor.exists() and not ancestor.is_dir():
        raise BadInput(f"{ancestor} is not a folder; choose another with -o")


def write_comparison(result: Comparison, folder: Path) -> None:
    """Write all files; others in the folder stay. Raises BadInput where it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        replace_content(folder / NUMBERS, dumps(result.as_json(), indent=1) + "\n")
        for name, draw in PLOTS.items():
            replace_content(folder / name, draw(result))
        replace_content(folder / SHEET, sheet(result))
        replace_file(folder / RECORDING, lambda part: write_recording(part, result))
    except OSError as error:
        raise BadInput(f"{folder} cannot be written ({error.strerror}); choose another folder with -o") from error
