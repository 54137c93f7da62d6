"""Registration of two views: ICP from guesses and from PnP on matched features; one trusted motion, or none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float64Array, IndexArray
from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.features import match_features
from slam.frontend.gauss_newton.correspondences import MIN_INLIERS, Correspondences, solve_pnp
from slam.frontend.icp import COARSE, FINE, IcpResult, Level, icp
from slam.frontend.keyframes import View
from slam.frontend.rigid_matches import RigidMatches
from slam.se3 import angle_deg, length_m

# Correspondences within this many sigmas of a guess take part: the guess is only a guess.
NEAR_SIGMAS = 8.0
# Colour and depth are not taken at one moment, and neither is all of an image: tens of milliseconds are usual. While
# the camera turns, depth therefore lies off the pose, which is that of the colour image.
EXPOSURE_GAP_S = 0.05
# Depth that fits as well as the sensor at rest lets it, in sigmas, was not smeared, however fast the camera is said to
# have turned: stamps may be no times. If it were smeared, more would be left.
SHARP_RMS = 0.7
# Depth has wrong minima near the right one, some a few millimetres away, where most of it agrees too; so starts that
# lead to different places are all followed to the end.
SAME_M, SAME_DEG = 0.003, 0.1
SAME_FIT = 0.003  # what noise may account for
ENOUGH_OVERLAP = 0.5  # of a view, for its fit to tell as much as that of all of it; less tells the less
# RANSAC's iterations for PnP; many where views are far apart and most matches wrong.
TRIES, MANY_TRIES = 100, 1000
LOOK = replace(FINE, iterations=1)  # what is reported is how the start fits
# What is trusted: enough of the view's points lie on the other's surface, or enough features agree, and no direction
# is left open.
MIN_SCORE, MIN_FEATURES = 0.25, 30
MIN_AGREEMENT = 0.5  # where views overlap and most readings disagree, one of them is elsewhere
# Where hardly a feature agrees either: of two places half the depth agrees soon, floor with floor and wall with wall.
FEW_FEATURES, MIN_LONE_AGREEMENT = 8, 2 / 3
MAX_RMS = 2.0  # sigmas; surfaces that do not fit each other have more
MAX_SIGMA_RAD, MAX_SIGMA_M = 0.02, 0.03  # along the least certain axes; tracking goes on from anything better
MAX_LAST_STEP = 1.0  # sigmas; what still moves by more than it is said to be known is not known


@dataclass(frozen=True)
class _ViewPair:
    """All that the registration of one view to another starts from."""

    target: View
    source: View
    correspondences: Correspondences
    calibration: ColorCalibration
    noise: DepthNoise

    def coarse(self, guess: Float64Array) -> Float64Array:
        """target_from_source after the coarse level alone."""
        source, target = self.source.pyramid.levels[:1], self.target.pyramid.levels[:1]
        near = self._near(guess)
        return icp(source, target, guess, near, self.calibration, self.noise, (COARSE,)).target_from_source

    def fine(self, start: Float64Array, level: Level = FINE) -> IcpResult:
        """The motion after the fine level."""
        return self.best([start], lambda _: True, level)

    def best(
        self, starts: Sequence[Float64Array], may_be: Callable[[Float64Array], bool], level: Level = FINE
    ) -> IcpResult:
        """The most plausible motion after the fine level, from any of the starts, of those that may be. All are held to
        the same noise: a wrong one, taken to be smeared, would fit better than a right one that is sharp."""
        at_rest = self._best(starts, may_be, self.noise.without_smear(), level)
        is_sharp = self.noise.smear == 0 or at_rest.rms <= SHARP_RMS
        return at_rest if is_sharp else self._best(starts, may_be, self.noise, level)

    def _best(
        self, starts: Sequence[Float64Array], may_be: Callable[[Float64Array], bool], noise: DepthNoise, level: Level
    ) -> IcpResult:
        results = [self._fine(start, noise, level) for start in starts]
        return most_plausible([result for result in results if may_be(result.target_from_source)] or results)

    def _fine(self, start: Float64Array, noise: DepthNoise, level: Level) -> IcpResult:
        source, target = self.source.pyramid.levels[1:], self.target.pyramid.levels[1:]
        return icp(source, target, start, self._near(start), self.calibration, noise, (level,))

    def _near(self, guess: Float64Array) -> Correspondences:
        return self.correspondences.select(
            self.correspondences.inliers(guess, self.calibration.parameters, NEAR_SIGMAS)
        )


@dataclass(frozen=True)
class ViewRegistration:
    """Brings views together, under the settings of features and depth."""

    config: SlamConfig

    def register(
        self,
        target: View,
        source: View,
        guesses: Sequence[Float64Array],
        calibration: ColorCalibration,
        rigid: RigidMatches | None = None,
        matches: IndexArray | None = None,
        may_be: Callable[[Float64Array], bool] = lambda _: True,
    ) -> IcpResult | None:
        """The motion target_from_source from the best of the guesses and of what the features alone say; None where
        there is nothing to start from.

        Args:
            target: the view that stays.
            source: the view that is brought to it.
            guesses: target_from_source (4, 4) to start from, possibly none.
            calibration: the colour camera as known so far.
            rigid: features that match from afar, where views may be far apart: they take part, are tried for longer,
                and say where to start by their distances, too.
            matches: of the features of both, where they are known.
            may_be: whether a motion (4, 4) is possible; others compete with none that is.
        """
        correspondences = self._correspondences(target, source, matches, rigid)
        guesses = [*guesses, *_feature_starts(correspondences, calibration, rigid)]
        pair = self._pair(target, source, Correspondences.joined(correspondences), calibration)
        starts = _distinct([pair.coarse(guess) for guess in guesses])
        return pair.best(starts, may_be) if starts else None

    def refine(
        self,
        target: View,
        source: View,
        guess: Float64Array,
        calibration: ColorCalibration,
        rigid: RigidMatches | None = None,
        matches: IndexArray | None = None,
    ) -> IcpResult:
        """The motion target_from_source from a guess that is all but right.

        Args:
            target: the view that stays.
            source: the view that is brought to it.
            guess: target_from_source (4, 4).
            calibration: the colour camera as known so far.
            rigid: features that match from afar, if they take part.
            matches: of the features of both, where they are known.
        """
        correspondences = Correspondences.joined(self._correspondences(target, source, matches, rigid))
        return self._pair(target, source, correspondences, calibration).fine(guess)

    def fit(
        self, target: View, source: View, motion: Float64Array, calibration: ColorCalibration, matches: IndexArray
    ) -> IcpResult:
        """How a motion fits that stays as it is.

        Args:
            target: the view that stays.
            source: the view that is brought to it.
            motion: target_from_source (4, 4).
            calibration: the colour camera as known so far.
            matches: of the features of both.
        """
        correspondences = self._correspondences(target, source, matches, None)[0]
        result = self._pair(target, source, correspondences, calibration).fine(motion, LOOK)
        return replace(result, target_from_source=motion, calibration=calibration)

    def match(self, target: View, source: View) -> IndexArray:
        """Matches (M, 2) of the features of two views, however their cameras turned."""
        return match_features(target.features, source.features, self.config.features)

    def _correspondences(
        self, target: View, source: View, matches: IndexArray | None, rigid: RigidMatches | None
    ) -> list[Correspondences]:
        """Those of the usual features, and of those that match from afar, if these take part."""
        pairs = self.match(target, source) if matches is None else matches
        turning = target.turning_rad_s, source.turning_rad_s
        usual = Correspondences.of(target.features, source.features, pairs, *turning)
        if rigid is None:
            return [usual]
        return [usual, Correspondences.of(target.wide.features, source.wide.features, rigid.pairs, *turning)]

    def _pair(
        self, target: View, source: View, correspondences: Correspondences, calibration: ColorCalibration
    ) -> _ViewPair:
        smear = EXPOSURE_GAP_S * max(float(np.linalg.norm(view.turning_rad_s)) for view in (target, source))
        return _ViewPair(target, source, correspondences, calibration, DepthNoise(self.config.depth, smear))


def _feature_starts(
    correspondences: Sequence[Correspondences], calibration: ColorCalibration, rigid: RigidMatches | None
) -> list[Float64Array]:
    """Motions target_from_source (4, 4) that features say: by their distances, and where these tell little by PnP."""
    starts = [rigid.motion()] if rigid is not None and rigid.n_agreeing >= MIN_INLIERS else []
    if rigid is not None and rigid.is_sure:
        return starts
    tries = TRIES if rigid is None else MANY_TRIES
    solved = [solve_pnp(matched, calibration, tries) for matched in correspondences]
    return [start for start in solved if start is not None] + starts


def _distinct(motions: Sequence[Float64Array]) -> list[Float64Array]:
    """Those that differ from all before them by more than the fine level bridges surely."""
    kept: list[Float64Array] = []
    for motion in motions:
        offsets = [inverse(earlier) @ motion for earlier in kept]
        if all(length_m(offset) > SAME_M or angle_deg(offset) > SAME_DEG for offset in offsets):
            kept.append(motion)
    return kept


def most_plausible(results: Sequence[IcpResult]) -> IcpResult:
    """The one whose depth fits best, and the first unless another is better. Features do not decide: where colour is
    not registered they are wrong in consistent sets, and the colour camera bends to explain them at a wrong motion; a
    wrong depth seldom fits."""
    best = max(results, key=_closeness)
    return best if _closeness(best) > _closeness(results[0]) + SAME_FIT else results[0]


def _closeness(result: IcpResult) -> float:
    """How well depth fits where both views have it. What overlaps less is no worse for that: depth that slides along a
    wall slides to where it overlaps most, which is where the other view was."""
    return result.fit / max(result.overlap, ENOUGH_OVERLAP)


def is_trusted(result: IcpResult, min_score: float = MIN_SCORE, min_features: int = MIN_FEATURES) -> bool:
    """Whether depth or features agree well enough, and the motion was to be solved for."""
    min_agreement = MIN_LONE_AGREEMENT if result.n_features < FEW_FEATURES else MIN_AGREEMENT
    depth_agrees = result.score >= min_score and result.agreement >= min_agreement and result.rms <= MAX_RMS
    if result.overlap >= min_score and result.agreement < MIN_AGREEMENT:
        return False
    return (depth_agrees or result.n_features >= min_features) and _is_certain(*result.solved_sigma)


def leaves_open(result: IcpResult) -> bool:
    """Whether nothing that both views show says how the camera moved along some direction: there the noise of normals
    keeps tracking near where it was, and tells nothing of places."""
    return not _is_certain(*result.sigma)


def is_at_rest(result: IcpResult) -> bool:
    """Whether the motion had come to rest. Where little holds it, it creeps, and is where it was left off: that may be
    anywhere between where it was started and where it belongs."""
    return result.last_step <= MAX_LAST_STEP


def _is_certain(turn_rad: float, shift_m: float) -> bool:
    return turn_rad <= MAX_SIGMA_RAD and shift_m <= MAX_SIGMA_M
