"""Registration of colour to depth for a run: estimated, read from a file, or left as it is."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from app.console.waiting import waiting_for
from app.frames.cameras.run_registration import read_calibration_for
from data_tools.calibration.rgbd_estimate import RgbdEstimate, estimate_rgbd_calibration
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from data_tools.recordings.sequence import RgbdSequence
from data_tools.synthetic.rendered_frames import RenderedFrames
from razer.errors import BadInput
from razer.frame import Intrinsics

FORMAT = 1


@dataclass(frozen=True)
class ColorRegistration:
    """The colour camera that a run uses beside the depth camera, None = they are one; `estimate`: what was estimated,
    None where it was not."""

    depth_camera: Intrinsics
    calibration: RgbdCalibration | None = None
    estimate: RgbdEstimate | None = None

    @property
    def warp(self) -> ColorWarp | None:
        """What brings colour onto depth; None where it lies there."""
        return None if self.calibration is None else ColorWarp.between(self.depth_camera, self.calibration)

    def to_json(self) -> dict[str, Any]:
        """Format 1 of rgbd_calibration.json: `color` and `color_from_depth` are those in use, `rgbd` the estimate."""
        in_use = self.calibration or RgbdCalibration(self.depth_camera, np.eye(4))
        estimate = None if self.estimate is None else self.estimate.to_json()
        return {"format": FORMAT, "applied": self.calibration is not None, **in_use.to_json(), "rgbd": estimate}


def register_color(sequence: RgbdSequence, choice: str, console: Console) -> ColorRegistration:
    """How colour lies to depth in a recording; one line on the console says what was found.

    Args:
        sequence: the recording.
        choice: auto, off, or a file as `RgbdCalibration.to_json` describes it.
        console: where the line goes.

    Raises:
        BadInput: for a file that cannot be used.
    """
    camera = sequence.intrinsics
    if choice == "off" or (choice == "auto" and _is_declared(sequence)):
        return ColorRegistration(camera)
    if choice != "auto":
        if _is_declared(sequence):
            raise BadInput(
                f"{choice} and the recording, or --depth-to-color, both say where the colour camera is: drop one"
            )
        return ColorRegistration(camera, read_calibration_for(Path(choice), camera))
    with waiting_for("comparing colour with depth", console):
        estimate = estimate_rgbd_calibration(sequence)
    if estimate.may_be_far_off and not estimate.confident:
        console.print(
            f"WARNING: colour may be {estimate.mean_px:.0f} pixels off depth and is left as it is: {estimate.reason}; "
            "--rgbd-calibration FILE says where the colour camera is",
            soft_wrap=True,
        )
    if not estimate.matters:
        return ColorRegistration(camera, None, estimate)
    console.print(f"{estimate}: corrected (--rgbd-calibration off leaves it)", soft_wrap=True)
    return ColorRegistration(camera, estimate.calibration, estimate)


def json_text(registration: ColorRegistration) -> str:
    """What rgbd_calibration.json holds."""
    return json.dumps(registration.to_json(), indent=1) + "\n"


def _is_declared(sequence: RgbdSequence) -> bool:
    """Whether the recording, or the user, says where the colour camera stands; what is rendered here has no other."""
    if isinstance(sequence, RecordedSequence):
        return sequence.rgbd_alignment.warp is not None
    return isinstance(sequence, RenderedFrames)
