"""Intrinsics of the depth camera from pairs of views, and how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from razer.arrays import Float64Array
from razer.frame import Intrinsics
from slam.config import DepthSettings
from slam.frontend.depth_noise import DepthNoise
from slam.intrinsics.camera_adjustment import MIN_MATCHES, CameraAdjustment, ViewPair

MIN_PAIRS, MIN_GROUPS = 8, 4  # of views, and of stretches of the recording, for a spread to be measured
FREE_ASPECT = 0.03  # prior of square pixels that lets views say otherwise
WORTH_A_WORD, SURE_SIGMAS = 0.04, 4.0  # share of the guessed focal length; what has been calibrated is not nagged at
MAX_SIGMA = 0.015  # of the focal length, as a share: with more, the guess may as well stay


@dataclass(frozen=True)
class IntrinsicsEstimate:
    """A pinhole camera from views, and the guess that it is from; sigma_px (4,), of fx, fy, cx and cy; n_pairs of views
    that it is from; `confident`: whether they determine it, else `reason` says why not."""

    guess: Intrinsics
    intrinsics: Intrinsics
    sigma_px: tuple[float, float, float, float]
    n_pairs: int
    reason: str = ""

    @property
    def confident(self) -> bool:
        """Whether the views determine the camera."""
        return not self.reason

    @property
    def contradicts_guess(self) -> bool:
        """Whether the focal length is surely another one, by more than is worth a word."""
        pairs = ((self.intrinsics.fx, self.guess.fx), (self.intrinsics.fy, self.guess.fy))
        off = max(abs(found / guess - 1) for found, guess in pairs)
        sigma = max(self.sigma_px[:2]) / self.guess.fx
        return self.confident and off > max(WORTH_A_WORD, SURE_SIGMAS * sigma)

    def to_json(self) -> dict[str, Any]:
        """fx, fy, cx, cy, their deviations, pairs, confident and reason; null = not known."""
        camera = self.intrinsics
        return {
            "fx": camera.fx,
            "fy": camera.fy,
            "cx": camera.cx,
            "cy": camera.cy,
            "sigma_px": [sigma if np.isfinite(sigma) else None for sigma in self.sigma_px],
            "pairs": self.n_pairs,
            "confident": self.confident,
            "reason": self.reason or None,
        }

    def __str__(self) -> str:
        if not self.confident:
            return f"cannot be refined: {self.reason}"
        camera, sigma = self.intrinsics, self.sigma_px
        return (
            f"focal lengths {camera.fx:.1f} {camera.fy:.1f} ± {max(sigma[:2]):.1f} pixels, centre {camera.cx:.1f} "
            f"{camera.cy:.1f} ± {max(sigma[2:]):.1f}, by {self.n_pairs} pairs of views"
        )


def estimate_intrinsics(pairs: Sequence[ViewPair], guess: Intrinsics, depth: DepthSettings) -> IntrinsicsEstimate:
    """The camera under which the views of each pair are of one rigid world.

    Args:
        pairs: matched views, best of cameras that turned between them.
        guess: the camera to start from, whose focal lengths may be off by a third.
        depth: the noise of the depth sensor.
    """
    usable = [pair for pair in pairs if len(pair.matches) >= MIN_MATCHES]
    adjustment = CameraAdjustment.begun(usable, guess, DepthNoise(depth)) if usable else None
    n_pairs = 0 if adjustment is None else len(adjustment.motions)
    if adjustment is None or n_pairs < MIN_PAIRS or len(np.unique(adjustment.groups)) < MIN_GROUPS:
        reason = f"only {n_pairs} pairs of views show the same from two sides, and {MIN_PAIRS} from all over are needed"
        return IntrinsicsEstimate(guess, guess, (np.inf,) * 4, n_pairs, reason)
    solved = adjustment.solved()
    sigma = np.hypot(solved.sigma_px(), _unsquare_px(solved) / 2)
    fx, fy, cx, cy = solved.camera.tolist()
    camera = Intrinsics(guess.width, guess.height, fx, fy, cx, cy)
    deviations = (float(sigma[0]), float(sigma[1]), float(sigma[2]), float(sigma[3]))
    return IntrinsicsEstimate(guess, camera, deviations, n_pairs, _doubt(solved.camera, sigma))


def _unsquare_px(solved: CameraAdjustment) -> float:
    """By how many pixels the two focal lengths come apart if they may. As pixels are square, that is an error, of which
    scattered noise knows nothing: of a lens, a rolling shutter, or colour that is not of the moment of depth."""
    free = replace(solved, aspect=FREE_ASPECT).descended().camera
    return abs(float(free[0] - free[1] * solved.guess[0] / solved.guess[1]))


def _doubt(camera: Float64Array, sigma: Float64Array) -> str:
    """Why an estimate cannot be trusted, in a plain line; empty where it can."""
    share = float((sigma[:2] / camera[:2]).max())
    if share <= MAX_SIGMA:
        return ""
    return (
        f"the views leave the focal length open by {share:.1%} ({MAX_SIGMA:.1%} is the limit): the camera must turn to "
        "and fro, slowly, before things at several depths"
    )
