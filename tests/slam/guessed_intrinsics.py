"""How well intrinsics are found again from wrong guesses: `python -m tests.slam.guessed_intrinsics [--maps] NAME ...`.

NAME is a folder with a recording whose intrinsics are known, or room:SEED[:WIDTH], a synthetic room with a Kinect's
noise and errors. With --maps every fourth frame is also tracked, with the guess and with what was found: error of the
path (ATE, aligned to the given poses) and how thick surfaces become, the median over cells of 20 cm of the standard
deviation across the surface in them.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from rich.console import Console

from app.frames.cameras.color_registration import register_color
from app.frames.cameras.refined_camera import intrinsics_of_views
from app.pipeline.track_only import TrackedPath, tracked_path
from app.settings.run_config import InputSettings, RunConfig
from data_tools import open_sequence
from data_tools.recordings.sequence import FrameIteration, RgbdSequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.arrays import Float64Array
from razer.frame import Frame, Intrinsics
from razer.geometry import transform_points

FACTORS = (0.8, 0.9, 1.1, 1.2)
CENTRE_PX = (10.0, -10.0)  # of an image 640 wide
ROOM_FRAMES = 360
CELL_M, MIN_IN_CELL, EVERY_FRAME, EVERY_PIXEL = 0.2, 60, 2, 8
MAP_STRIDE = 4


@dataclass
class Guessed(FrameIteration):
    """A recording with other intrinsics."""

    sequence: RgbdSequence
    intrinsics: Intrinsics
    has_poses: bool = True
    depth_scale: float = 1000.0

    @property
    def name(self) -> str:
        return self.sequence.name

    def __len__(self) -> int:
        return len(self.sequence)

    def __getitem__(self, index: int) -> Frame:
        return replace(self.sequence[index], intrinsics=self.intrinsics)


def guess_of(camera: Intrinsics, factor: float) -> Intrinsics:
    """Focal lengths off by a factor, and the centre by CENTRE_PX."""
    unit = camera.width / 640
    cx, cy = camera.cx + CENTRE_PX[0] * unit, camera.cy + CENTRE_PX[1] * unit
    return replace(camera, fx=camera.fx * factor, fy=camera.fy * factor, cx=cx, cy=cy)


def opened(name: str) -> RgbdSequence:
    """The recording of a name."""
    if not name.startswith("room:"):
        return open_sequence(name)
    seed, width = (int(part) for part in ([*name.split(":")[1:], "640"])[:2])
    return SyntheticRoom(seed, ROOM_FRAMES, width, width * 3 // 4, sensor=SensorModel.kinect())


def thickness_mm(sequence: RgbdSequence, path: TrackedPath) -> float:
    """How thick the surfaces are that frames show under the poses of a path."""
    points = np.concatenate([_points(sequence[index], pose) for index, pose in list(path.final.items())[::EVERY_FRAME]])
    cells, inverse = np.unique(np.floor(points / CELL_M).astype(int), axis=0, return_inverse=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    starts = np.searchsorted(inverse.ravel()[order], np.arange(len(cells) + 1))
    members = [points[order[a:b]] for a, b in itertools.pairwise(starts) if b - a >= MIN_IN_CELL]
    return 1e3 * float(np.median([np.sqrt(np.linalg.eigvalsh(np.cov(cell.T))[0]) for cell in members]))


def _points(frame: Frame, pose: Float64Array) -> Float64Array:
    k, depth = frame.intrinsics, frame.depth[::EVERY_PIXEL, ::EVERY_PIXEL].astype(np.float64)
    v, u = np.mgrid[: k.height : EVERY_PIXEL, : k.width : EVERY_PIXEL]
    near = (depth > 0) & (depth < 4)
    x, y = (u - k.cx) / k.fx * depth, (v - k.cy) / k.fy * depth
    return transform_points(pose, np.stack([x, y, depth], axis=-1)[near])


def mapped(sequence: RgbdSequence) -> str:
    """ATE and thickness under estimated poses."""
    config = RunConfig(input=InputSettings(stride=MAP_STRIDE))
    path = tracked_path(sequence, config, Console(quiet=True))
    ate: Any = path.as_json()["ate_rmse_m"]
    return f"{len(path.final):4d} located, ATE {100 * (ate or np.nan):5.2f} cm, {thickness_mm(sequence, path):5.1f} mm"


def report(name: str, factor: float, with_maps: bool) -> None:
    """One line of how a guess was corrected."""
    sequence = opened(name)
    true, guess = sequence.intrinsics, guess_of(sequence.intrinsics, factor)
    start_s = process_time()
    recording = Guessed(sequence, guess)
    found = intrinsics_of_views(recording, register_color(recording, "auto", Console(quiet=True)))
    camera, sigma = found.intrinsics, found.sigma_px
    off = [getattr(camera, part) - getattr(true, part) for part in ("fx", "fy", "cx", "cy")]
    figures = "  ".join(f"{error:+6.1f} ± {deviation:4.1f}" for error, deviation in zip(off, sigma, strict=True))
    share = max(abs(off[0]) / true.fx, abs(off[1]) / true.fy)
    print(f"{Path(name).name:20} {factor - 1:+4.0%}: {figures}   {share:5.2%}  {found.n_pairs:3d} pairs, "
          f"{process_time() - start_s:4.1f} s {found.reason}", flush=True)  # fmt: skip
    if with_maps:
        for what, intrinsics in (("the guess", guess), ("refined", camera)):
            print(f"    {what:10} {mapped(Guessed(sequence, intrinsics))}", flush=True)


def main(arguments: Sequence[str]) -> None:
    """Print a line for each recording and guess; errors of fx, fy, cx, cy in pixels, and of the focal length."""
    with_maps = "--maps" in arguments
    for name in [argument for argument in arguments if argument != "--maps"]:
        if with_maps:
            print(f"{Path(name).name:20}  true: {mapped(opened(name))}", flush=True)
        for factor in FACTORS:
            report(name, factor, with_maps)


if __name__ == "__main__":
    main(sys.argv[1:])
