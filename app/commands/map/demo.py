"""`razer demo`: a small synthetic room becomes a map, with nothing to download."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import serving
from app.profiling.cores import leave_cores_to_helpers
from app.run_folder.run_folder import RunFolder
from app.settings.config_file import read_config
from app.settings.options import Flag, SettingOptions
from app.settings.run_config import InputSettings

if TYPE_CHECKING:
    from data_tools.recordings.sequence import RgbdSequence

ROOM_FRAMES = 120
ROOM_SIZE = (480, 360)  # pixels; half the work of 640x480
_ABOUT = (
    "A simulated room: masks and class names come from the simulator (segmenter and embedder 'oracle'), not from "
    "a 2D model; what is shown is the mapping. On recordings of your own, `razer run` uses the 2D models that are "
    "here: `razer models pull starter` brings some that know names; without any it goes by depth and colour."
)
_QUESTION = "something to sit on"
_PICTURE = "demo.png"


def demo(
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])] = Path("demo_run"),
    frames: int = ROOM_FRAMES,
    options: SettingOptions = SettingOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Map a small synthetic room that the project renders itself; no data or models are needed.

    Things and surfaces are named, a question is asked, and OUT/demo.png shows both.

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
    oracle = {"segmenter.name": "oracle", "segmenter.options.stuff": True, "embedder.name": "oracle"}
    config = read_config(options.config, options.set, oracle, trust=options.trust, preset=options.preset)

    # Late, as in `razer run`.
    leave_cores_to_helpers()
    with waiting_for("building a room"):
        from app.pipeline.run_pipeline import run_to_folder
        from app.pipeline.run_report import print_run
        from data_tools.synthetic.synthetic_room import SyntheticRoom

        room = SyntheticRoom(0, frames, *ROOM_SIZE)
    result = run_to_folder(room, config, target, progress_console())
    with waiting_for("cutting pictures of its things"):
        _keep_crops(target.final, room, config.input)
    if not json:
        result_console().print(_ABOUT)
    print_run(result, target.final, as_json=json)
    if not json:
        _ask(target.final)
    return result.exit_code


def _keep_crops(folder: Path, room: RgbdSequence, settings: InputSettings) -> None:
    """Cut the pictures of all instances now: nobody can render the room again from the folder."""
    from app.query.view_crops import ViewCrops
    from razer.saved_map import load_map

    crops = ViewCrops(folder, settings, room)
    for item in load_map(folder).objects:
        crops.of(item)


def _ask(folder: Path) -> None:
    """Ask the map a question, draw it with its names and the answer, and say how to ask more."""
    from app.pictures.answer_sheet import answer_sheet
    from app.pictures.picture_file import write_picture
    from razer.saved_map import load_map

    panoptic, console = load_map(folder), result_console()
    hits = panoptic.query(_QUESTION).hits
    found = ", ".join(f"{hit.object.class_name} {hit.object.id}" for hit in hits) or "nothing"
    with waiting_for("drawing the map and the answer"):
        write_picture(folder / _PICTURE, answer_sheet(panoptic, _QUESTION, hits))
    console.print(f'asked for "{_QUESTION}": {found}', soft_wrap=True)
    console.print(f"picture: {folder / _PICTURE}", soft_wrap=True)
    print_next(("query", folder, "dishes"), ("view", folder, "--page", folder / "map.html"), *serving(folder))
