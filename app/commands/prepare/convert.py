"""`razer convert`: conversion of a recording to the project's own or another dataset's layout."""

from __future__ import annotations

import os
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.console.outputs import print_files, print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import mapping
from app.pipeline.interrupt import INTERRUPTED
from app.run_folder.folder_lock import writing
from app.settings.options import Flag, RecordingOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.frames.selection import Selection
    from app.settings.run_config import InputSettings

FORMAT = 1
MAX_NAMED = 5


def convert(
    folder: Path,
    out: Path,
    /,
    *,
    layout: str = "own",
    options: RecordingOptions = RecordingOptions(),  # noqa: B008
    lossless: Flag = False,
    json: Flag = False,
) -> int:
    """Convert a recording to another layout, with its ground truth if it has one; unusable frames are left out.

    Parameters
    ----------
    folder:
        The recording: a folder, a .bag, a .r3d or a .sens; its layout is detected.
    out:
        The folder to write; it appears when it is complete.
    layout:
        own, scannet, sens (ScanNet's single file), replica, tum, scenenn or 7scenes.
    lossless:
        Write colour as PNG where the layout would have JPEG.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    settings = options.input_settings()
    if os.path.lexists(os.path.abspath(out)):
        raise BadInput(f"{out} exists: give a new folder, or remove it first")
    with writing(out):
        return _convert(folder, out, layout, settings, lossless=lossless, as_json=json)


def _convert(folder: Path, out: Path, layout: str, settings: InputSettings, *, lossless: bool, as_json: bool) -> int:
    # Late, since OpenCV and SciPy take a moment to load: help and wrong usage should not wait for them.
    with waiting_for("starting"):
        from app.frames.open_recording import open_recording
        from app.frames.selection import Selection, selected_frames
        from data_tools.recordings.recorded_sequence import in_world
        from data_tools.truth.open_truth import has_truth, open_truth
        from data_tools.writers.table import write_recording

    console = progress_console()
    sequence = in_world(open_recording(folder, settings, console))
    selection = Selection.of(sequence, selected_frames(sequence, settings), console)
    with waiting_for("reading the truth"):
        truth = open_truth(folder) if has_truth(folder) else None
    try:
        skipped = write_recording(selection, out, layout, truth=truth, lossless=lossless)
    except KeyboardInterrupt:
        console.print(f"interrupted: {out} is not written")
        return INTERRUPTED
    selection.finish()
    result = _summary(selection, out, layout, skipped, truth is not None)
    if as_json:
        print(dumps(result))
    else:
        _report(result, out)
    return 0


def _summary(
    selection: Selection, out: Path, layout: str, skipped: list[tuple[int, str]], has_truth: bool
) -> dict[str, Any]:
    """The line of `razer convert --json` (format 1)."""
    return {
        "format": FORMAT,
        "recording": selection.name,
        "out": str(out),
        "layout": layout,
        "frames": len(selection),
        "written": len(selection) - len(skipped),
        "skipped": [{"frame": selection.indices[index], "reason": reason} for index, reason in skipped],
        "truth": has_truth,
    }


def _report(result: dict[str, Any], out: Path) -> None:
    console = result_console()
    truth = " with their ground truth" if result["truth"] else ""
    for each in result["skipped"][:MAX_NAMED]:
        console.print(f"skipped frame {each['frame']}: {each['reason']}", soft_wrap=True)
    if (more := len(result["skipped"]) - MAX_NAMED) > 0:
        console.print(f"skipped {more} more; --json names them all")
    count = f"{result['written']} of {result['frames']} frames{truth}, layout {result['layout']}"
    console.print(f"{result['out']}: {count}", soft_wrap=True)
    print_files(out)
    print_next(mapping(out, beside=True), ("inspect", out))
