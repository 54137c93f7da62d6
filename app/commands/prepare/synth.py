"""`razer synth`: a recording of a simulated place, of which everything is known."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cyclopts import Parameter

from app.console.exit_codes import INTERRUPTED
from app.console.streams import progress_console, result_console
from app.settings.assignments import split_assignment
from app.settings.options import Assignments, Flag
from razer.errors import BadInput

if TYPE_CHECKING:
    from data_tools.synthetic.camera.sensor_model import SensorModel
    from data_tools.synthetic.synthetic_scene import SyntheticScene

FORMAT = 1
SPACING_M = (0.002, 0.1)


@Parameter(name="*")
@dataclass(frozen=True)
class SceneOptions:
    """What is filmed, and with what."""

    scene: str = "room"
    """room, apartment, corridor-loop, tabletop or warehouse."""
    seed: int = 0
    """What stands where, in which colours, and the hand that holds the camera."""
    frames: int = 0
    """Frames of the walk, spread evenly over it; 0 = as many as make 15 a second."""
    size: str = "640x480"
    """Width x height of the images, pixels."""
    sensor: Literal["kinect", "plain", "none"] = "kinect"
    """kinect: every error of such a camera; plain: noise and lost edges; none: an ideal camera."""
    set: Assignments = ()
    """One error of the sensor as name=strength; may be repeated. 0 switches it off."""

    def film(self) -> SyntheticScene:
        """The recording; raises BadInput."""
        match = re.fullmatch(r"(\d+)x(\d+)", self.size)
        if not match or not all(8 <= int(n) <= 8192 for n in match.groups()):
            raise BadInput(f"--size {self.size}: write it as 640x480")
        from data_tools.synthetic.synthetic_scene import SyntheticScene

        width, height = int(match[1]), int(match[2])
        return SyntheticScene(self.scene, self.seed, self.frames, width, height, sensor=self.sensor_model())

    def sensor_model(self) -> SensorModel:
        """The sensor with some errors of another strength; raises BadInput."""
        from data_tools.synthetic.camera.sensor_model import SensorModel

        changes: dict[str, Any] = {}
        known = [field.name for field in fields(SensorModel) if field.name != "range_m"]
        for assignment in self.set:
            name, text = split_assignment(assignment, f"error=strength, with one of {', '.join(known)}", known)
            try:
                changes[name] = float(text)
            except ValueError:
                raise BadInput(f"--set {assignment}: {text} is no number") from None
        model: SensorModel = getattr(SensorModel, self.sensor)()
        return replace(model, **changes)


def synth(
    out: Path,
    /,
    *,
    options: SceneOptions = SceneOptions(),
    layout: str = "own",
    spacing: float = 0.015,
    lossless: Flag = False,
    json: Flag = False,
) -> int:
    """Write a recording of a simulated place with poses, instance ids and ground truth.

    Parameters
    ----------
    out:
        The folder to write; it appears when it is complete.
    layout:
        own, scannet, sens, replica, tum, scenenn or 7scenes.
    spacing:
        Distance of the vertices of the true surface, metres.
    lossless:
        Write colour as PNG where the layout would have JPEG.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    # Late, since these bring Open3D along.
    from app.frames.selection import Selection
    from data_tools.writers.table import WRITERS, write_recording

    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    if not SPACING_M[0] <= spacing <= SPACING_M[1]:
        raise BadInput(f"--spacing {spacing:g}: give {SPACING_M[0]:g} to {SPACING_M[1]:g} metres")
    if out.exists():
        raise BadInput(f"{out} exists: give a new folder, or remove it first")
    film, console = options.film(), progress_console()
    part = Selection.of(film, 1, None, console)
    try:
        console.print("finding out what can be seen of the scene")
        truth = film.truth(spacing)
        skipped = write_recording(layout, part, out, truth=truth, lossless=lossless)
    except KeyboardInterrupt:
        console.print(f"interrupted: {out} is not written")
        return INTERRUPTED
    part.finish()
    names = truth.instance_classes
    result = {"format": FORMAT, "out": str(out), "scene": options.scene, "seed": options.seed, "layout": layout}
    result |= {"sensor": options.sensor, "frames": len(film), "written": len(film) - len(skipped)}
    result |= {"instances": len(names), "classes": len({*names.values()}), "vertices": len(truth.vertices)}
    _report(result, json)
    return 0


def _report(result: dict[str, Any], json: bool) -> None:
    if json:
        print(dumps(result))
        return
    made = "{out}: {written} frames, {instances} instances of {classes} classes".format(**result)
    result_console().print(made, soft_wrap=True)
