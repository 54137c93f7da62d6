"""`razer synth`: a rendered synthetic recording with complete ground truth."""

from __future__ import annotations

import os
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.console.outputs import print_files, print_next
from app.console.streams import print_notes, progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import mapping
from app.pipeline.interrupt import INTERRUPTED
from app.run_folder.folder_lock import writing
from app.settings.options import Flag
from app.settings.synthetic_options import SceneOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from data_tools.synthetic.rendered_frames import RenderedFrames

FORMAT = 1
SPACING_M = (0.002, 0.1)


def synth(
    out: Path,
    /,
    *,
    options: SceneOptions = SceneOptions(),  # noqa: B008
    layout: str = "own",
    spacing: float = 0.015,
    lossless: Flag = False,
    json: Flag = False,
) -> int:
    """Render a recording of a synthetic scene or a labelled mesh with poses, instance ids and ground truth.

    Parameters
    ----------
    out:
        The folder to write; it appears when it is complete.
    layout:
        own, scannet, sens, replica, tum, scenenn or 7scenes.
    spacing:
        Vertex spacing of the ground-truth surface, metres; wider in large worlds, and a mesh keeps its own.
    lossless:
        Write colour as PNG where the layout would have JPEG.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    with waiting_for("starting"):  # late, since these bring Open3D along
        from app.frames.selection import Selection
        from data_tools.writers.table import write_recording

    _check_arguments(out, layout, spacing)
    console = progress_console()
    try:
        with writing(out):
            with waiting_for("building the scene and its light"):
                sequence = options.sequence(console.print)
            print_notes(_notes(sequence, spacing))
            selection = Selection.of(sequence, range(len(sequence)), console)
            with waiting_for("computing which surfaces are visible"):
                truth = sequence.truth(spacing)
            skipped = write_recording(selection, out, layout, truth=truth, lossless=lossless)
    except KeyboardInterrupt:
        console.print(f"interrupted: {out} is not written")
        return INTERRUPTED
    selection.finish()
    scene, names = options.scene if options.mesh is None else None, truth.instance_classes
    result = {"format": FORMAT, "out": str(out), "scene": scene, "seed": options.seed, "layout": layout}
    result |= {"sensor": options.sensor, "frames": len(sequence), "written": len(sequence) - len(skipped)}
    result |= {"instances": len(names), "classes": len({*names.values()}), "vertices": len(truth.vertices)}
    _report(result | dict(sequence.summary), out, json)
    return 0


def _notes(sequence: RenderedFrames, wanted_m: float) -> list[str]:
    spacing_m, notes = sequence.truth_spacing_m(wanted_m), [*sequence.notes]
    if spacing_m > wanted_m:
        apart = f"{100 * spacing_m:.1f} cm apart, not {100 * wanted_m:.1f}"
        notes.append(f"vertices of the ground truth are {apart}: the world is large, and they would be too many")
    return notes


def _check_arguments(out: Path, layout: str, spacing: float) -> None:
    from data_tools.writers.table import WRITERS

    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    if not SPACING_M[0] <= spacing <= SPACING_M[1]:
        raise BadInput(f"--spacing {spacing:g}: give {SPACING_M[0]:g} to {SPACING_M[1]:g} metres")
    if os.path.lexists(os.path.abspath(out)):
        raise BadInput(f"{out} exists: give a new folder, or remove it first")


def _report(result: dict[str, Any], out: Path, json: bool) -> None:
    if json:
        print(dumps(result))
        return
    summary = "{out}: {written} frames, {instances} instances of {classes} classes".format(**result)
    result_console().print(summary, soft_wrap=True)
    print_files(out)
    print_next(mapping(out, beside=True), ("inspect", out))
