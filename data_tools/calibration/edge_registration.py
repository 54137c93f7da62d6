"""Registration of depth rims to colour edges: annealed mean shift along the rims' normals, solved by Gauss-Newton.

The colour camera is the same in all frames, but depth and colour of one frame are not taken at one moment: a turning
camera moves colour by a lag times the image's flow, and by what is left as an offset of each frame, whose prior is a
Student distribution. Without it frames in which the camera turns would pass for a camera that stands elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_tools.calibration.color_camera import N_PARAMETERS, REGISTERED, ColorProjection
from data_tools.calibration.color_edges import ColorEdges
from data_tools.calibration.depth_rims import DepthRims
from razer.arrays import Float64Array

COARSE_PX, FINE_PX = (16.0, 11.0, 8.0, 5.5, 4.0), (2.8, 2.0, 1.4)
"""Widths of the search along a normal, one after the other."""
_ITERATIONS = 4
_COARSE_STEP, _FINE_STEP = 6, 2  # of the rims, one in so many takes part
# Prior deviations: zoom, shift in pixels of an image 640 wide, baseline in metres, roll in radians (1.1 degrees), and
# the lag in frames.
PRIOR = np.array([0.1, 30.0, 30.0, 0.05, 0.05, 0.05, 0.02, 1.0])
_N_UNKNOWN = N_PARAMETERS + 1
_SHIFT = [1, 2]
_OFFSET_PX, _MIN_OFFSET_PX, _MAX_OFFSET_PX = 8.0, 0.5, 20.0  # deviation of the frames' offsets: at first, and bounds
_STUDENT = 2.0  # degrees of freedom: heavy tails, since cameras stand still and turn fast in one recording
# Rims of one object err together: their information counts by this share. Set so that the predicted error of the
# camera is about the true one on synthetic recordings.
_INDEPENDENT_SHARE = 0.1
_MIN_RIMS = 20  # of a frame that takes part


@dataclass(frozen=True)
class RimView:
    """One frame: its depth rims, its colour edges, and how its image flows (2,), pixels a frame."""

    rims: DepthRims
    edges: ColorEdges
    flow_px: Float64Array

    def thinned(self, step: int) -> RimView:
        """With one rim in `step`."""
        return RimView(self.rims.thinned(step), self.edges, self.flow_px)


@dataclass(frozen=True)
class EdgeFit:
    """The colour camera (7,), the lag in frames, offsets (F, 2) in pixels that each frame keeps, the covariance (7, 7)
    of the camera, and the typical distance of a rim from its colour edge, pixels."""

    parameters: Float64Array
    lag: float
    offsets_px: Float64Array
    covariance: Float64Array
    residual_px: float

    @classmethod
    def start(cls, parameters: Float64Array, n_frames: int) -> EdgeFit:
        """A camera to start from."""
        return cls(parameters, 0.0, np.zeros((n_frames, 2)), np.diag(PRIOR[:N_PARAMETERS] ** 2), np.inf)


@dataclass(frozen=True)
class _NormalEquations:
    """Information (8, 8) and gradient (8,) of one frame in units of PRIOR, with the weights of its rims."""

    information: Float64Array
    gradient: Float64Array
    weight: float
    residual_px: float


@dataclass(frozen=True)
class _FrameTerm:
    """Normal equations of one frame that also know its own offset (2,), whose information with its prior is `own`."""

    information: Float64Array
    gradient: Float64Array
    own: Float64Array

    @classmethod
    def of(cls, term: _NormalEquations, unit: float, offset: Float64Array, spread: float) -> _FrameTerm:
        """A frame's term in a unit of weight, its offset as it is now, and the offsets' spread, in units of PRIOR."""
        information = term.information / unit
        student = (_STUDENT + 2) / (_STUDENT + float((offset**2).sum()) / spread**2)
        own = information[np.ix_(_SHIFT, _SHIFT)] + np.eye(2) * student / spread**2
        # The offset is solved for anew, from nothing: what it explains now is added back.
        return cls(information, term.gradient / unit + information[:, _SHIFT] @ offset, own)

    def without_offset(self) -> tuple[Float64Array, Float64Array]:
        """Information and gradient of the camera alone, the offset being free within its prior."""
        gain = self.information[:, _SHIFT] @ np.linalg.inv(self.own)
        return self.information - gain @ self.information[_SHIFT], self.gradient - gain @ self.gradient[_SHIFT]

    def offset(self, step: Float64Array) -> Float64Array:
        """The offset (2,) that goes with a step of the camera."""
        return np.asarray(np.linalg.solve(self.own, self.gradient[_SHIFT] - self.information[_SHIFT] @ step))


class EdgeRegistration:
    """Brings the rims of many frames onto their colour edges."""

    def __init__(self, views: Sequence[RimView], projection: ColorProjection) -> None:
        self._views = [view for view in views if len(view.rims) >= _MIN_RIMS]
        self._projection = projection
        self._px = projection.depth_camera.width / 640
        self._prior = PRIOR * np.array([1, self._px, self._px, 1, 1, 1, 1, 1])

    def __len__(self) -> int:
        return len(self._views)

    @property
    def width_px(self) -> int:
        """Width of the images."""
        return self._projection.depth_camera.width

    def part(self, start: int, step: int) -> EdgeRegistration:
        """The same of every step-th frame from `start`."""
        return EdgeRegistration(self._views[start::step], self._projection)

    def fit(self, start: EdgeFit, widths_px: Sequence[float]) -> EdgeFit:
        """The camera that puts rims on edges, from a first guess, searched at each of the widths."""
        fit, spread = start, _OFFSET_PX
        for width in widths_px:
            is_fine = width <= FINE_PX[0]
            views = [view.thinned(_FINE_STEP if is_fine else _COARSE_STEP) for view in self._views]
            for _ in range(_ITERATIONS):
                fit = self._step(views, fit, width * self._px, spread * self._px)
                if is_fine:
                    spread = self._spread(fit.offsets_px)
        return fit

    def score(self, fit: EdgeFit, width_px: float) -> float:
        """Mean squared strength of the colour edges under the rims, blurred by a width; rims that fall outside of the
        image count as none once they are more than half."""
        offsets = (width_px * self._px / 2) * np.arange(-3.0, 4.0)
        kernel = _gaussian(offsets, width_px * self._px)
        total, n = 0.0, 0.0
        for view, offset in zip(self._views, fit.offsets_px, strict=True):
            rims, pixels = self._visible(view, fit.parameters, fit.lag * view.flow_px + offset)
            total += float((view.edges.profiles(pixels, rims.normals, offsets) ** 2 @ kernel).sum() / kernel.sum())
            n += max(len(rims), 0.5 * len(view.rims))
        return total / max(n, 1.0)

    def _visible(
        self, view: RimView, parameters: Float64Array, offset_px: Float64Array
    ) -> tuple[DepthRims, Float64Array]:
        rims = view.rims
        pixels = self._projection.pixels(parameters, rims.rays, rims.inverse_depth) + offset_px
        inside = view.edges.is_inside(pixels)
        return DepthRims(rims.rays[inside], rims.inverse_depth[inside], rims.normals[inside]), pixels[inside]

    def _step(self, views: Sequence[RimView], fit: EdgeFit, width_px: float, spread_px: float) -> EdgeFit:
        """One Gauss-Newton step; the frames' offsets are eliminated first (Schur complement), then found."""
        terms = [self._term(view, fit, offset, width_px) for view, offset in zip(views, fit.offsets_px, strict=True)]
        weights = [term.weight for term in terms if term.weight > 0]
        if not weights:
            return fit
        unit, per_shift = float(np.median(weights)), float(self._prior[1])
        scaled = [
            _FrameTerm.of(term, unit, offset / per_shift, spread_px / per_shift)
            for term, offset in zip(terms, fit.offsets_px, strict=True)
        ]
        reduced = [term.without_offset() for term in scaled]
        mean = np.append(fit.parameters - REGISTERED, fit.lag) / self._prior
        information = np.eye(_N_UNKNOWN) + sum(part for part, _ in reduced)
        step = np.linalg.solve(information, -mean + sum(part for _, part in reduced))
        moved, scale = step * self._prior, self._prior[:N_PARAMETERS]
        covariance = np.linalg.inv(information)[:N_PARAMETERS, :N_PARAMETERS] * np.outer(scale, scale)
        return EdgeFit(
            fit.parameters + moved[:N_PARAMETERS],
            fit.lag + float(moved[-1]),
            np.array([term.offset(step) for term in scaled]) * per_shift,
            covariance.astype(np.float64),
            float(np.median([term.residual_px for term in terms if term.weight > 0])),
        )

    def _term(self, view: RimView, fit: EdgeFit, offset_px: Float64Array, width_px: float) -> _NormalEquations:
        """Mean shift of each rim along its normal towards the colour edges around, as normal equations."""
        rims, pixels = self._visible(view, fit.parameters, fit.lag * view.flow_px + offset_px)
        if len(rims) < _MIN_RIMS:
            return _NormalEquations(np.zeros((_N_UNKNOWN, _N_UNKNOWN)), np.zeros(_N_UNKNOWN), 0.0, np.inf)
        reach = max(width_px / 2, 0.5) * np.arange(-6.0, 7.0)
        strength = view.edges.profiles(pixels, rims.normals, reach)
        # Texture answers everywhere along the normal; only what stands out of it counts.
        strength = np.maximum(strength - strength.mean(axis=1, keepdims=True), 0) ** 2
        pull = strength * _gaussian(reach, width_px)
        weight = pull.sum(axis=1)
        shift = (pull @ reach) / np.maximum(weight, 1e-9)
        jacobian = self._projection.jacobian(fit.parameters, rims.rays, rims.inverse_depth)
        along = np.einsum("ni,nij->nj", rims.normals, jacobian)
        along = np.column_stack([along, rims.normals @ view.flow_px]) * self._prior
        weighted = along * (_INDEPENDENT_SHARE * weight / max(width_px, 1.5 * self._px) ** 2)[:, None]
        residual = float(np.sqrt((weight * shift**2).sum() / max(weight.sum(), 1e-9)))
        return _NormalEquations(weighted.T @ along, weighted.T @ shift, float(weight.mean()), residual)

    def _spread(self, offsets_px: Float64Array) -> float:
        """Deviation of the frames' offsets, in pixels of an image 640 wide, from the median of their sizes."""
        spread = 1.4826 * float(np.median(np.abs(offsets_px))) / self._px
        return float(np.clip(spread, _MIN_OFFSET_PX, _MAX_OFFSET_PX))


def _gaussian(offsets: Float64Array, width: float) -> Float64Array:
    return np.exp(-(offsets**2) / (2 * width**2))
