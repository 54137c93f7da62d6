"""`razer synth`: a rendered synthetic recording with complete ground truth."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cyclopts import Parameter

from app.console.streams import progress_console, result_console
from app.pipeline.interrupt import INTERRUPTED
from app.settings.assignments import split_assignment
from app.settings.misalignment_options import MisalignmentOptions
from app.settings.options import Assignments, Flag
from razer.errors import BadInput

if TYPE_CHECKING:
    from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
    from data_tools.synthetic.camera.sensor_model import SensorModel
    from data_tools.synthetic.synthetic_scene import SyntheticScene

FORMAT = 1
SPACING_M = (0.002, 0.1)


@Parameter(name="*")
@dataclass(frozen=True)
class SceneOptions:
    """Synthetic scene, camera path and sensor model."""

    scene: str = "room"
    """room, apartment, corridor-loop, tabletop or warehouse."""
    seed: int = 0
    """Seed of layout, colours and camera shake."""
    frames: int = 0
    """Frames, spread evenly over the camera path; 0 = 15 a second."""
    size: str = "640x480"
    """Width x height of the images, pixels."""
    sensor: Literal["kinect", "plain", "none"] = "kinect"
    """kinect: every error of such a camera; plain: depth noise and missing edges; none: an ideal camera."""
    set: Assignments = ()
    """One error of the sensor model as name=strength; may be repeated. 0 switches it off."""

    def sequence(self, misalignment: RgbdMisalignment) -> SyntheticScene:
        """The recording, with colour so misaligned; raises BadInput."""
        match = re.fullmatch(r"(\d+)x(\d+)", self.size)
        if not match or not all(8 <= int(n) <= 8192 for n in match.groups()):
            raise BadInput(f"--size {self.size}: write it as 640x480")
        from data_tools.synthetic.synthetic_scene import SyntheticScene

        width, height = int(match[1]), int(match[2])
        cameras: dict[str, Any] = {"sensor": self.sensor_model(), "misalignment": misalignment}
        return SyntheticScene(self.scene, self.seed, self.frames, width, height, **cameras)

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
    colour: MisalignmentOptions = MisalignmentOptions(),  # noqa: B008
    layout: str = "own",
    spacing: float = 0.015,
    lossless: Flag = False,
    json: Flag = False,
) -> int:
    """Render a recording of a synthetic scene with poses, instance ids and ground truth.

    Parameters
    ----------
    out:
        The folder to write; it appears when it is complete.
    layout:
        own, scannet, sens, replica, tum, scenenn or 7scenes.
    spacing:
        Vertex spacing of the ground-truth surface, metres.
    lossless:
        Write colour as PNG where the layout would have JPEG.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    # Late, since these bring Open3D along.
    from app.frames.selection import Selection
    from data_tools.writers.table import write_recording

    _check_arguments(out, layout, spacing)
    sequence, console = options.sequence(colour.misalignment()), progress_console()
    selection = Selection.of(sequence, 1, None, console)
    try:
        console.print("computing which surfaces are visible")
        truth = sequence.truth(spacing)
        skipped = write_recording(selection, out, layout, truth=truth, lossless=lossless)
    except KeyboardInterrupt:
        console.print(f"interrupted: {out} is not written")
        return INTERRUPTED
    selection.finish()
    names = truth.instance_classes
    result = {"format": FORMAT, "out": str(out), "scene": options.scene, "seed": options.seed, "layout": layout}
    result |= {"sensor": options.sensor, "frames": len(sequence), "written": len(sequence) - len(skipped)}
    result |= {"instances": len(names), "classes": len({*names.values()}), "vertices": len(truth.vertices)}
    if sequence.calibration is not None:
        result |= {"rgbd_calibration": sequence.calibration.to_json()}
    _report(result, json)
    return 0


def _check_arguments(out: Path, layout: str, spacing: float) -> None:
    from data_tools.writers.table import WRITERS

    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    if not SPACING_M[0] <= spacing <= SPACING_M[1]:
        raise BadInput(f"--spacing {spacing:g}: give {SPACING_M[0]:g} to {SPACING_M[1]:g} metres")
    if out.exists():
        raise BadInput(f"{out} exists: give a new folder, or remove it first")


def _report(result: dict[str, Any], json: bool) -> None:
    if json:
        print(dumps(result))
        return
    summary = "{out}: {written} frames, {instances} instances of {classes} classes".format(**result)
    result_console().print(summary, soft_wrap=True)
