"""Verified registration: a view in front of a keyframe that tracking did not lead to, or nothing where it may be
elsewhere as well."""

from __future__ import annotations

from collections.abc import Sequence

from razer.arrays import Float64Array
from slam.backend.view_checks.color_check import color_correlation
from slam.backend.view_checks.free_space_check import contradiction
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.rigid_matches import RigidMatches, RigidMotion
from slam.frontend.view_registration import ViewRegistration, is_at_rest, is_trusted, leaves_open

# Features that agree: enough by themselves where depth does not agree (more than tracking asks for, which has a motion
# model besides), and at least where appearance alone led to the pair.
ENOUGH_FEATURES, MIN_FEATURES = 40, 8
# Of pictures that have wide features alone: these are a third to a half of what both kinds are together.
ENOUGH_WIDE, MIN_WIDE = 15, 6
# A start by features alone is off by so much at the most; what it contradicts beyond that is another place.
START_OFF_M, MAX_START_CONTRADICTION = 0.1, 0.1
MORE_ROUNDS = 4  # of iterations, for a registration that has not come to rest


class VerifiedRegistration:
    """Registers views to keyframes, and believes what space, colours and features bear out.

    Args:
        keyframes: those that views are registered to.
        config: the settings.
        wide_alone: whether views have wide features and no others, as pictures far apart do.
    """

    def __init__(self, keyframes: Keyframes, config: SlamConfig, wide_alone: bool = False) -> None:
        self._wide_alone = wide_alone
        self._enough, self._least = (ENOUGH_WIDE, MIN_WIDE) if wide_alone else (ENOUGH_FEATURES, MIN_FEATURES)
        self._keyframes, self._registration = keyframes, ViewRegistration(config)
        self._settings, self._free_space = config.loop_closure, config.free_space

    def register(
        self, keyframe: Keyframe, view: View, guesses: Sequence[Float64Array], calibration: ColorCalibration
    ) -> IcpResult | None:
        """Register a view to a keyframe near which it is known to be.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guesses: keyframe_from_view (4, 4) to start from.
            calibration: the colour camera as known so far.
        """
        rigid = _prominent_matches(keyframe, view) if self._wide_alone else None
        return self._verified(keyframe, view, guesses, calibration, rigid, is_known=self._wide_alone)

    def recognise(
        self,
        keyframe: Keyframe,
        view: View,
        guesses: Sequence[Float64Array],
        calibration: ColorCalibration,
        rigid: RigidMatches | None = None,
    ) -> IcpResult | None:
        """Register a view to a keyframe that appearance or a hypothesis led to: some of its features must agree, too.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guesses: keyframe_from_view (4, 4) to start from, if any.
            calibration: the colour camera as known so far.
            rigid: features of both that match from afar, where they are known.
        """
        result = self._verified(keyframe, view, guesses, calibration, rigid or _wide_matches(keyframe, view))
        return None if result is None or result.n_features < self._least else result

    def register_in_part(
        self, keyframe: Keyframe, view: View, guess: Float64Array, calibration: ColorCalibration, min_overlap: float
    ) -> IcpResult | None:
        """Register a view to a keyframe that may share little with it. By itself that is not to be believed.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guess: keyframe_from_view (4, 4) to start from.
            calibration: the colour camera as known so far.
            min_overlap: share of the view that must lie on what the keyframe shows.
        """
        rigid = _all_matches(keyframe, view)  # of the few features in what is shared each counts
        return self._verified(keyframe, view, [guess], calibration, rigid, min_overlap=min_overlap)

    def rigid_motion(
        self, keyframe: Keyframe, view: View, rigid: RigidMatches | None = None, hints: bool = False
    ) -> RigidMotion | None:
        """How a view may lie in front of a keyframe, roughly, by a tenth of what a registration costs; None where too
        few features lie as far from each other in both, or where space or colours contradict the motion these have.

        Args:
            keyframe: what it lies in front of.
            view: the view.
            rigid: features of both that match from afar, where they are known.
            hints: whether fewer features are enough, that say where to look.
        """
        rigid = rigid or _wide_matches(keyframe, view)
        if not (rigid.is_sure or (hints and rigid.is_hint)):
            return None
        motion = rigid.motion()
        if not self._is_possible(keyframe, view, motion, START_OFF_M, MAX_START_CONTRADICTION):
            return None
        return RigidMotion(motion, rigid.n_explained, rigid.information, rigid.is_sure)

    def _verified(
        self,
        keyframe: Keyframe,
        view: View,
        guesses: Sequence[Float64Array],
        calibration: ColorCalibration,
        rigid: RigidMatches | None,
        is_known: bool = False,
        min_overlap: float | None = None,
    ) -> IcpResult | None:
        least = self._settings.min_overlap if min_overlap is None else min_overlap
        result = self._settled(keyframe, view, guesses, calibration, rigid, is_known, least)
        if result is None:
            return None
        motion, most = result.target_from_source, self._settings.max_contradiction
        return result if self._is_possible(keyframe, view, motion, 0.0, most) else None

    def _is_possible(
        self, keyframe: Keyframe, view: View, motion: Float64Array, off_m: float, max_contradiction: float
    ) -> bool:
        """Whether space, and colours, bear out a motion that may be off by so much."""
        standing = contradiction(keyframe.view, view, motion, self._free_space, off_m)
        return standing <= max_contradiction and self._looks_alike(keyframe, view, motion)

    def _looks_alike(self, keyframe: Keyframe, view: View, motion: Float64Array) -> bool:
        alike = color_correlation(keyframe.view, view, motion, self._free_space)
        return alike >= self._settings.min_color_correlation

    def _settled(
        self,
        keyframe: Keyframe,
        view: View,
        guesses: Sequence[Float64Array],
        calibration: ColorCalibration,
        rigid: RigidMatches | None,
        is_known: bool,
        min_overlap: float,
    ) -> IcpResult | None:
        """A registration that came to rest where features or depth agree, and leave no direction open; from the first
        guess alone where the view is known to lie all but there."""
        target = self._keyframes.view(keyframe)
        if is_known:
            result: IcpResult | None = self._registration.refine(target, view, guesses[0], calibration, rigid)
        else:
            result = self._registration.register(target, view, guesses, calibration, rigid)
        for _ in range(MORE_ROUNDS):
            if result is None or not self._holds(result, min_overlap):
                return None
            if is_at_rest(result):
                return result
            result = self._registration.refine(target, view, result.target_from_source, calibration, rigid)
        return None

    def _holds(self, result: IcpResult, min_overlap: float) -> bool:
        return not leaves_open(result) and is_trusted(result, min_overlap, self._enough)


def _prominent_matches(keyframe: Keyframe, view: View) -> RigidMatches:
    return RigidMatches(keyframe.view.wide.prominent, view.wide.prominent)


def _wide_matches(keyframe: Keyframe, view: View) -> RigidMatches:
    """The features of a keyframe and a view that match from afar: prominent ones, or all where these are not enough."""
    prominent = _prominent_matches(keyframe, view)
    return prominent if prominent.is_sure else _all_matches(keyframe, view)


def _all_matches(keyframe: Keyframe, view: View) -> RigidMatches:
    return RigidMatches(keyframe.view.wide.features, view.wide.features)
