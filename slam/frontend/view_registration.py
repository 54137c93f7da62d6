"""Two views brought together: from guesses and look-alike features to one trusted motion, or none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.correspondences import Correspondences, solve_pnp
from slam.frontend.depth_pyramid import SurfaceGrid
from slam.frontend.features import matches
from slam.frontend.icp import COARSE, FINE, IcpResult, icp
from slam.frontend.keyframes import View
from slam.se3 import angle_deg, length_m

Grids = tuple[SurfaceGrid, ...]

# Sightings within this many sigmas of a guess take part: the guess is only a guess.
NEAR_SIGMAS = 8.0
# Colour and depth are not taken at one moment, and neither is all of an image: tens of milliseconds are usual. While
# the camera turns, depth therefore lies off the pose, which is that of the colour image.
EXPOSURE_GAP_S = 0.05
# Depth has wrong minima near the right one, some a few millimetres away, where most of it agrees too; so starts that
# lead to different places are all followed to the end.
SAME_M, SAME_DEG = 0.003, 0.1
SAME_FIT = 0.003  # what noise may account for
TRIES, MANY_TRIES = 100, 1000  # to find sightings that agree; many where views are far apart and most matches wrong


def register_views(
    target: View,
    target_grids: Grids,
    source: View,
    source_grids: Grids,
    guesses: Sequence[Float64Array],
    camera: ColorCamera,
    tries: int = TRIES,
) -> IcpResult | None:
    """The motion target_from_source from the best of the guesses and of what the features alone say, found in so many
    tries; None where there is nothing to start from."""
    sightings, smear = _sightings(target, source), _smear(target, source)
    start = solve_pnp(sightings, camera, tries)
    guesses = [*guesses, *([] if start is None else [start])]
    starts = _distinct([_coarse(target_grids, source_grids, guess, sightings, camera, smear) for guess in guesses])
    found = [_fine(target_grids, source_grids, start, sightings, camera, smear) for start in starts]
    return _most_plausible(found) if found else None


def refine_registration(
    target: View, target_grids: Grids, source: View, source_grids: Grids, guess: Float64Array, camera: ColorCamera
) -> IcpResult:
    """The motion target_from_source from a guess that is all but right."""
    smear = _smear(target, source)
    return _fine(target_grids, source_grids, guess, _sightings(target, source), camera, smear)


def _sightings(target: View, source: View) -> Correspondences:
    pairs = matches(target.features, source.features)
    return Correspondences.of(target.features, source.features, pairs, target.turning_rad_s, source.turning_rad_s)


def _smear(target: View, source: View) -> float:
    return EXPOSURE_GAP_S * max(float(np.linalg.norm(view.turning_rad_s)) for view in (target, source))


def _coarse(
    target: Grids, source: Grids, guess: Float64Array, sightings: Correspondences, camera: ColorCamera, smear: float
) -> Float64Array:
    near = sightings.select(sightings.inliers(guess, camera.parameters, NEAR_SIGMAS))
    return icp(source[:1], target[:1], guess, near, camera, (COARSE,), smear).target_from_source


def _fine(
    target: Grids, source: Grids, start: Float64Array, sightings: Correspondences, camera: ColorCamera, smear: float
) -> IcpResult:
    near = sightings.select(sightings.inliers(start, camera.parameters, NEAR_SIGMAS))
    return icp(source[1:], target[1:], start, near, camera, (FINE,), smear)


def _distinct(motions: Sequence[Float64Array]) -> list[Float64Array]:
    """Those that differ from all before them by more than the fine level bridges surely."""
    kept: list[Float64Array] = []
    for motion in motions:
        off = [inverse(other) @ motion for other in kept]
        if all(length_m(o) > SAME_M or angle_deg(o) > SAME_DEG for o in off):
            kept.append(motion)
    return kept


def _most_plausible(starts: Sequence[IcpResult]) -> IcpResult:
    """The one whose depth fits best, and the first unless another is better. Features do not decide: where colour is
    not registered they are wrong in consistent sets, and the colour camera bends to explain them at a wrong motion; a
    wrong depth seldom fits."""
    best = max(starts, key=lambda start: start.fit)
    return best if best.fit > starts[0].fit + SAME_FIT else starts[0]


def is_trusted(found: IcpResult, min_score: float = 0.25, min_features: int = 30) -> bool:
    """Whether depth or features agree well enough, and leave no direction open."""
    turn, shift = found.sigma
    depth_agrees = found.score >= min_score and found.agreement >= 0.5 and found.rms <= 2.0
    if found.overlap >= min_score and found.agreement < 0.5:
        return False
    return (depth_agrees or found.n_features >= min_features) and turn <= 0.02 and shift <= 0.03
