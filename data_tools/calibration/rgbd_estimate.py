"""RGB-D self-calibration: the colour camera of a recording whose colour does not fit its depth, and its certainty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from data_tools.calibration.color_camera import REGISTERED, ColorProjection
from data_tools.calibration.edge_registration import COARSE_PX, FINE_PX, EdgeFit, EdgeRegistration, RimView
from data_tools.calibration.sampled_views import SampledViews
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Float64Array
from razer.frame import Intrinsics

# To start from: the search bridges some 20 pixels from each. After two levels the most promising go on.
_ZOOMS = (1.0, 0.91, 1.09)
_SHIFTS_PX = ((0.0, 0.0), (24.0, 0.0), (-24.0, 0.0), (0.0, 24.0), (0.0, -24.0))
_N_ROUGH, _N_PROMISING = 2, 3
_SURELY_BETTER = 1.02  # times the score of a start before it
_MIN_VIEWS = 8
# An estimate is trusted whose predicted error stays below a pixel (deviation) everywhere, whose two halves of the
# views agree, so that their mean is within 2 pixels, whose edges lie on colour more than chance does, and whose colour
# camera stands where one can be built in. All pixels are those of an image 640 wide.
_MAX_SIGMA_PX, _MAX_HALVES_PX, _CLEAR = 1.0, 4.0, 1.7
_MAX_BASELINE_M = 0.1
# The covariance is that of views which are all new; of views that are not, so many count as one. Set by redkitchen,
# where estimates from 60 frames in a row differ from that of all 600 by 3 to 19 pixels.
_VIEWS_OF_ONE_CONTENT = 0.5
# Smaller ones are below what the estimate resolves, and what masks are shrunk by.
_NEGLIGIBLE_PX = 2.0
_FAR_OFF = 0.01  # share of the width


@dataclass(frozen=True)
class RgbdEstimate:
    """A colour camera against the depth camera of a recording.

    A far point that depth shows at pixel p, from the middle of the image, lies at zoom p + shift_px in colour; the
    colour camera stands at baseline_m (x right, y down, z forward) in the depth camera and is rolled by roll_deg about
    its axis. mean_px: by how far colour is
    off on average over the image and the depths shown, max_px: at most; sigma_px: the largest deviation of the
    estimate there; residual_px: typical distance of a depth edge from its colour edge after it; `confident`: whether
    the images determine it, else `reason` says why not.
    """

    parameters: Float64Array
    depth_camera: Intrinsics
    mean_px: float = 0.0
    max_px: float = 0.0
    sigma_px: float = np.inf
    residual_px: float = np.inf
    reason: str = ""

    @property
    def confident(self) -> bool:
        """Whether the images determine it."""
        return not self.reason

    @property
    def may_be_far_off(self) -> bool:
        """Whether colour, as well as the images tell, is off by more than 1 % of their width, surely or not."""
        return self.mean_px > _FAR_OFF * self.depth_camera.width

    @property
    def matters(self) -> bool:
        """Whether colour is surely off by more than the estimate may err."""
        return self.confident and self.mean_px > _NEGLIGIBLE_PX * self.depth_camera.width / 640

    @property
    def calibration(self) -> RgbdCalibration:
        """The colour camera, and where it stands."""
        return ColorProjection(self.depth_camera).calibration(self.parameters)

    def to_json(self) -> dict[str, Any]:
        """zoom, shift_px, baseline_m, residual_px, confident and the rest; null = not known."""
        zoom, *rest = self.parameters.tolist()
        return {
            "zoom": zoom,
            "shift_px": rest[:2],
            "baseline_m": rest[2:5],
            "roll_deg": float(np.degrees(rest[5])),
            "residual_px": _finite(self.residual_px),
            "mean_px": self.mean_px,
            "max_px": self.max_px,
            "sigma_px": _finite(self.sigma_px),
            "confident": self.confident,
            "reason": self.reason or None,
        }

    def __str__(self) -> str:
        if not self.confident:
            return f"whether colour fits depth cannot be told: {self.reason}"
        if not self.matters:
            return f"colour and depth fit, within {self.mean_px:.1f} pixels"
        zoom, x, y, *baseline, roll = self.parameters.tolist()
        place = " ".join(f"{100 * value:+.1f}" for value in baseline)
        return (
            f"colour is zoomed by {zoom:.3f}, shifted by {x:+.1f} {y:+.1f} pixels, rolled by {np.degrees(roll):+.1f} "
            f"degrees and seen from {place} cm against depth: {self.mean_px:.0f} pixels off on average"
        )


def estimate_rgbd_calibration(sequence: RgbdSequence) -> RgbdEstimate:
    """Estimate the colour camera from some thirty frames of a recording; takes a few seconds, needs no poses."""
    return estimate_from_views(SampledViews.of(sequence), sequence.intrinsics)


def estimate_from_views(sampled: SampledViews, depth_camera: Intrinsics) -> RgbdEstimate:
    """The same from views that were sampled."""
    projection = ColorProjection(depth_camera)
    registration = EdgeRegistration(sampled.views, projection)
    nothing = RgbdEstimate(REGISTERED, depth_camera)
    if len(registration) < _MIN_VIEWS:
        return replace(nothing, reason=f"depth edges are in {len(registration)} frames, of {_MIN_VIEWS} needed")
    fit = registration.fit(_best_start(registration), FINE_PX)
    off = projection.displacement_px(fit.parameters, REGISTERED, sampled.depths_m)
    return RgbdEstimate(
        fit.parameters,
        depth_camera,
        mean_px=float(off.mean()),
        max_px=float(off.max()),
        sigma_px=_sigma_px(fit, projection, sampled),
        residual_px=fit.residual_px,
        reason=_doubt(registration, fit, projection, sampled),
    )


def _best_start(registration: EdgeRegistration) -> EdgeFit:
    """The fit of the coarse levels, of several zooms and shifts to start from, that puts rims on the strongest colour
    edges."""
    unit_px = registration.width_px / 640
    starts = [
        EdgeFit.start(np.array([zoom, x * unit_px, y * unit_px, *REGISTERED[3:]]), len(registration))
        for x, y in _SHIFTS_PX
        for zoom in _ZOOMS
    ]
    rough = [registration.fit(start, COARSE_PX[:_N_ROUGH]) for start in starts]
    scores = [registration.score(fit, COARSE_PX[_N_ROUGH]) for fit in rough]
    promising = sorted(range(len(rough)), key=lambda i: -scores[i])[:_N_PROMISING]
    best, best_score = None, 0.0
    for i in sorted({0, *promising}):  # the recording as it is declared always among them, and preferred
        fit = registration.fit(rough[i], COARSE_PX[_N_ROUGH:])
        score = registration.score(fit, FINE_PX[0])
        if best is None or score > _SURELY_BETTER * best_score:
            best, best_score = fit, score
    assert best is not None
    return best


def _doubt(registration: EdgeRegistration, fit: EdgeFit, projection: ColorProjection, sampled: SampledViews) -> str:
    """Why a fit cannot be trusted, in a plain line; empty where it can."""
    unit_px = projection.depth_camera.width / 640
    width = FINE_PX[-1]
    chance = EdgeRegistration(_mismatched(sampled.views), projection)
    by_chance = chance.score(EdgeFit.start(fit.parameters, len(chance)), width)
    if registration.score(fit, width) < _CLEAR * by_chance:
        return "depth edges lie on colour edges no more than by chance"
    sigma = _sigma_px(fit, projection, sampled)
    if sigma > _MAX_SIGMA_PX * unit_px:
        limit = f"{_MAX_SIGMA_PX * unit_px:.1f} is the limit: more of the place must be seen"
        return f"depth edges leave the colour camera open by {sigma:.1f} pixels ({limit})"
    if float(np.abs(fit.parameters[3:6]).max()) > _MAX_BASELINE_M:
        return "the colour camera would stand where none is built in"
    halves = [_refitted(registration.part(start, 2), fit) for start in (0, 1)]
    apart = float(projection.displacement_px(halves[0], halves[1], sampled.depths_m).max())
    if apart > _MAX_HALVES_PX * unit_px:
        return f"one half of the frames says otherwise than the other, by {apart:.1f} pixels"
    return ""


def _sigma_px(fit: EdgeFit, projection: ColorProjection, sampled: SampledViews) -> float:
    """The largest deviation of where the colour camera sees things, over the image and the depths shown."""
    if_all_new = float(projection.sigma_px(fit.parameters, fit.covariance, sampled.depths_m).max())
    repeats = _VIEWS_OF_ONE_CONTENT * len(sampled.views) / sampled.n_independent
    return if_all_new * float(np.sqrt(max(1.0, repeats)))


def _mismatched(views: tuple[RimView, ...]) -> list[RimView]:
    """The rims of each view with the colour of another."""
    half = len(views) // 2
    others = views[half:] + views[:half]
    return [replace(view, edges=other.edges) for view, other in zip(views, others, strict=True)]


def _refitted(part: EdgeRegistration, fit: EdgeFit) -> Float64Array:
    start = EdgeFit.start(fit.parameters, len(part))
    return part.fit(replace(start, lag=fit.lag), (COARSE_PX[-1], *FINE_PX)).parameters


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
