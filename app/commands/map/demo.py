"""`razer demo`: a small synthetic room becomes a map, with nothing to download."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.console.streams import progress_console, result_console
from app.pipeline.interrupt import INTERRUPTED
from app.profiling.cores import leave_cores_to_helpers
from app.run_folder.run_folder import RunFolder
from app.settings.config_file import read_config
from app.settings.options import Flag, SettingOptions

ROOM_FRAMES = 120
ROOM_SIZE = (480, 360)  # pixels; half the work of 640x480
_ABOUT = (
    "A simulated room: masks and class names come from the simulator (segmenter and embedder 'oracle'), not from "
    "a 2D model; what is shown is the mapping. On recordings of your own, `razer run` finds masks in depth and "
    "colour, and instances stay nameless."
)
_QUESTION = "something to sit on"


def demo(
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])] = Path("demo_run"),
    frames: int = ROOM_FRAMES,
    options: SettingOptions = SettingOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Map a small synthetic room that the project renders itself; no data or models are needed.

    Parameters
    ----------
    out:
        The folder to write; an older run there is replaced.
    frames:
        Length of the walk through the room.
    json:
        End standard output with one line of JSON, as `razer run` does.
    """
    target = RunFolder(out, overwrite=True)
    oracle = {"segmenter.name": "oracle", "embedder.name": "oracle"}
    config = read_config(options.config, options.set, oracle, trust=options.trust, preset=options.preset)

    # Late, as in `razer run`.
    leave_cores_to_helpers()
    from app.pipeline.run_pipeline import run_to_folder
    from app.pipeline.run_report import print_run
    from data_tools.synthetic.synthetic_room import SyntheticRoom

    result = run_to_folder(SyntheticRoom(0, frames, *ROOM_SIZE), config, target, progress_console())
    if not json:
        result_console().print(_ABOUT)
    print_run(result, target.final, as_json=json)
    if not json:
        _ask(target.final)
    return INTERRUPTED if result.accounting.interrupted else 0


def _ask(folder: Path) -> None:
    """Ask the map a question, and say how to ask more."""
    from razer.saved_map import load_map

    hits = load_map(folder).query(_QUESTION).hits
    found = ", ".join(f"{hit.object.class_name} {hit.object.id}" for hit in hits) or "nothing"
    result_console().print(f'asked for "{_QUESTION}": {found}')
    result_console().print(f'ask more: razer query {folder} "dishes"', soft_wrap=True)
