"""Intrinsics of a recording as its own views tell them: sampled, estimated, and put in the place of a guess."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
from rich.console import Console

from app.console.waiting import waiting_for
from app.frames.cameras.color_registration import ColorRegistration, register_color
from app.settings.run_config import InputSettings
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from slam.config import SlamConfig
from slam.intrinsics.camera_adjustment import ViewPair
from slam.intrinsics.intrinsics_estimate import IntrinsicsEstimate, estimate_intrinsics
from slam.intrinsics.matched_views import DepthFeatures, ViewMatches

N_STRETCHES = 12
# Frames of a stretch, counted from its first: close ones match where recordings are sparse, far ones have turned.
OFFSETS = (0, 2, 5, 11, 23, 47)
SETTINGS = SlamConfig()


def refined(sequence: RgbdSequence, settings: InputSettings, console: Console) -> RgbdSequence:
    """A recording with the intrinsics that its views tell, in place of guessed ones; the console says what they are, or
    that they stay. Raises BadInput for a recording whose intrinsics are no guess."""
    if not isinstance(sequence, RecordedSequence) or not sequence.rgbd_alignment.is_plain:
        raise BadInput(
            f"{sequence.name}: intrinsics are refined where colour and depth are images of one size without distortion "
            "and without a colour camera that is declared: leave --refine-intrinsics out"
        )
    with waiting_for("refining the intrinsics", console):
        registration = register_color(sequence, settings.rgbd_calibration, Console(quiet=True))
        estimate = intrinsics_of_views(sequence, registration)
    guess = f"guessed were {camera_text(sequence.intrinsics)}"
    if not estimate.confident:
        console.print(f"WARNING: the intrinsics {estimate}; {guess}, which stay", style="bold red", soft_wrap=True)
        return replace(sequence, camera_note=f"a guess that {estimate}")
    note = f"{estimate}; {guess}"
    console.print(f"intrinsics: {note}", soft_wrap=True, highlight=False)
    alignment = replace(sequence.rgbd_alignment, intrinsics=estimate.intrinsics)
    return replace(sequence, rgbd_alignment=alignment, camera_note=note)


def camera_text(camera: Intrinsics) -> str:
    """As --intrinsics reads it."""
    return ",".join(f"{value:.6g}" for value in (camera.fx, camera.fy, camera.cx, camera.cy))


def with_camera_of(settings: InputSettings, sequence: RgbdSequence) -> InputSettings:
    """Settings by which the recording is opened again with the intrinsics that it has now."""
    if not settings.guess_intrinsics:
        return settings
    known = {"intrinsics": camera_text(sequence.intrinsics), "depth_scale": sequence.depth_scale}
    note = getattr(sequence, "camera_note", "")
    return settings.model_copy(update=known | {"refine_intrinsics": False, "intrinsics_note": note or None})


def intrinsics_of_views(sequence: RgbdSequence, registration: ColorRegistration) -> IntrinsicsEstimate:
    """What some seventy frames of a recording say of its intrinsics, where it is known how colour lies to depth; takes
    some seconds, needs no poses."""
    guess, color = sequence.intrinsics, registration.estimate
    if color is not None and color.may_be_far_off and not color.confident:
        reason = "colour may not lie on depth, and where the colour camera stands cannot be told"
        return IntrinsicsEstimate(guess, guess, (np.inf,) * 4, 0, reason)
    views: dict[int, DepthFeatures] = {}
    for index in {index for stretch in _stretches(len(sequence)) for index in stretch}:
        try:
            frame = sequence[index]
        except UnusableFrame:
            continue
        frame = frame if registration.warp is None else registration.warp.registered(frame)
        views[index] = DepthFeatures.of(frame, SETTINGS)
    return estimate_intrinsics(_pairs(views, len(sequence)), guess, SETTINGS.depth)


def _stretches(n_frames: int) -> list[list[int]]:
    """Indices of the frames of each stretch that is looked at."""
    last_start = max(0, n_frames - 1 - OFFSETS[-1])
    starts = dict.fromkeys(np.linspace(0, last_start, N_STRETCHES).round().astype(int).tolist())
    return [[start + offset for offset in OFFSETS if start + offset < n_frames] for start in starts]


def _pairs(views: dict[int, DepthFeatures], n_frames: int) -> list[ViewPair]:
    """Pairs of one stretch, each once; the group of a pair is the part of the recording that it is of."""
    pairs = {pair for stretch in _stretches(n_frames) for pair in combinations(stretch, 2)}
    return [
        ViewPair(ViewMatches.of(views[a], views[b]), (a + b) * N_STRETCHES // (2 * n_frames))
        for a, b in sorted(pairs)
        if a in views and b in views
    ]
