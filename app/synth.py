"""`razer synth`: a recording of a simulated place, of which everything is known."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from app.consoles import progress_console, result_console
from app.options import Flag
from razer.frame import BadInput

if TYPE_CHECKING:
    from data_tools.worlds.sensor_model import SensorModel

INTERRUPTED = 130
FORMAT = 1


def synth(
    out: Path,
    /,
    *,
    scene: str = "room",
    seed: int = 0,
    frames: int = 0,
    size: str = "640x480",
    sensor: Literal["kinect", "plain", "none"] = "kinect",
    set: Annotated[tuple[str, ...], Parameter(name="--set", negative="", consume_multiple=False)] = (),
    layout: str = "own",
    lossless: Flag = False,
    json: Flag = False,
) -> int:
    """Write a recording of a simulated place with poses, instance ids and ground truth.

    Parameters
    ----------
    out:
        The folder to write; it appears when it is complete.
    scene:
        room, apartment, corridor-loop, tabletop or warehouse.
    seed:
        What stands where, in which colours, and the hand that holds the camera.
    frames:
        Frames of the walk; 0 = as many as make 15 a second.
    size:
        Width x height of the images, pixels.
    sensor:
        kinect: every error of such a camera; plain: noise and lost edges; none: an ideal camera.
    set:
        One error of the sensor as name=strength; may be repeated. 0 switches it off.
    layout:
        own, scannet, sens, replica, tum, scenenn or 7scenes.
    lossless:
        Write colour as PNG where the layout would have JPEG.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    match = re.fullmatch(r"(\d+)x(\d+)", size)
    if not match or not all(8 <= int(n) <= 8192 for n in match.groups()):
        raise BadInput(f"--size {size}: write it as 640x480")

    # Late, since these bring Open3D along.
    from app.selection import Selection
    from data_tools.worlds.scene import SyntheticScene
    from data_tools.writers.table import WRITERS, write_recording

    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    if out.exists():
        raise BadInput(f"{out} exists: give a new folder, or remove it first")
    width, height = (int(n) for n in match.groups())
    film = SyntheticScene(scene, seed, frames, width, height, sensor=_sensor(sensor, set))
    console = progress_console()
    part = Selection.of(film, 1, None, console)
    try:
        console.print("finding out what can be seen of the scene")
        truth = film.truth()
        skipped = write_recording(layout, part, out, truth=truth, lossless=lossless)
    except KeyboardInterrupt:
        console.print(f"interrupted: {out} is not written")
        return INTERRUPTED
    part.finish()
    things = len(truth.instance_classes)
    result = {"format": FORMAT, "out": str(out), "scene": scene, "seed": seed, "layout": layout, "sensor": sensor}
    result |= {"frames": len(film), "written": len(film) - len(skipped), "instances": things}
    result["classes"] = len({*truth.instance_classes.values()})
    if json:
        print(dumps(result))
    else:
        result_console().print(f"{out}: {result['written']} frames, {things} instances of {result['classes']} classes")
    return 0


def _sensor(preset: str, assignments: tuple[str, ...]) -> SensorModel:
    """The preset with some errors of another strength; raises BadInput."""
    from data_tools.worlds.sensor_model import SensorModel

    changes: dict[str, Any] = {}
    known = [field.name for field in fields(SensorModel) if field.name != "range_m"]
    for assignment in assignments:
        name, separator, text = (part.strip() for part in assignment.partition("="))
        if not separator or name not in known:
            raise BadInput(f"--set {assignment}: write error=strength, with one of {', '.join(known)}")
        try:
            changes[name] = float(text)
        except ValueError:
            raise BadInput(f"--set {assignment}: {text} is no number") from None
    model: SensorModel = getattr(SensorModel, preset)()
    return replace(model, **changes)
