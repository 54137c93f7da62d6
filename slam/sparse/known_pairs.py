"""Known pairs: what was measured of pictures, what all pairs together say of each, and which of them were registered.

Features alone say roughly how two pictures lie, and colours there whether they show one place, at a tenth of what a
registration costs. So all pairs bear each other out as they lie roughly, and are registered when something rests on
them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from slam.backend.view_checks.usual_colors import UsualColors
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes
from slam.sparse.camera_motion import CameraSpeed
from slam.sparse.measured_pair import MeasuredPair, Numbers, by_picture, surest_first
from slam.sparse.missing_pairs import missing_pairs
from slam.sparse.pair_support import pair_support

# Of ties on average: those of one place have -3 and more, as through doors; those of two, -5 to -20.
LEAST_SUPPORT = -5.0
LEAST_VOTE, MOST_VOTE = 0.1, 2.0  # of a tie
# Times the other colours that two parts may have on the whole: ties are few, and mostly edges, as through doors.
FEW_TIMES = 2.0
LEAST_USUAL = 0.006  # share of faint colours that blur makes other ones

Register = Callable[[MeasuredPair], MeasuredPair | None]


def as_it_is(pair: MeasuredPair) -> MeasuredPair:
    """A pair that needs no registration."""
    return pair


class KnownPairs:
    """The pairs that did not come to nothing.

    `by_number` has those of each picture by the other one, `supported` the same without those that others speak
    against. `usual_colors` is what share of colours differs between pictures so far apart as their features have them,
    `usual_where_placed` as registrations and the poses that follow have them: that is more where colour and depth are
    not of one moment or camera, as depth decides there. `speed` is how fast the camera was carried.

    Args:
        keyframes: the pictures.
        pairs: those that were measured.
        config: the settings.
        unrecognised: the pairs that were compared in vain.
        sure_colors: separation and share of other colours of pairs that were registered.
        register: a pair that was not registered yet as its registration has it; None where that came to nothing.
    """

    def __init__(
        self,
        keyframes: Keyframes,
        pairs: Sequence[MeasuredPair],
        config: SlamConfig,
        unrecognised: Collection[Numbers] = (),
        sure_colors: Sequence[tuple[float, float]] = (),
        register: Register = as_it_is,
    ) -> None:
        self._register, self._max_color_excess = register, config.submaps.max_color_excess
        separations, shares = [pair.separation for pair in pairs], [pair.other_colors for pair in pairs]
        self.usual_colors = UsualColors(separations, shares, LEAST_USUAL)
        apart, differing = [each[0] for each in sure_colors], [each[1] for each in sure_colors]
        self.usual_where_placed = UsualColors(apart, differing, LEAST_USUAL) if sure_colors else self.usual_colors
        self.speed = CameraSpeed(keyframes, pairs)
        missing = missing_pairs(keyframes, pairs, unrecognised, config.depth.max_depth_m)
        self._support = pair_support(pairs, self.usual_colors, missing)
        self._surest_first = [pair.ends for pair in surest_first(pairs, self._support)]
        self.by_number = by_picture(pairs)
        self.supported = by_picture([pair for pair in pairs if not self.are_unsupported([pair])])

    def __iter__(self) -> Iterator[MeasuredPair]:
        """The surest first."""
        return (self.by_number[a][b] for a, b in self._surest_first if b in self.by_number[a])

    def registered(self, pair: MeasuredPair) -> MeasuredPair | None:
        """A pair once it is registered; None, and it is none any more, if that comes to nothing."""
        a, b = pair.ends
        known = self.by_number[a].get(b)
        if known is None or known.is_registered:
            return known
        found = self._register(known)
        registered = None if found is None else replace(found, is_next=pair.is_next, is_registered=True)
        for table in (self.by_number, self.supported):
            if registered is not None and b in table.get(a, {}):
                table[a][b] = table[b][a] = registered
        if registered is None:
            self.forget([known])
        return registered

    def forget(self, pairs: Iterable[MeasuredPair]) -> None:
        """Let pairs be none any more, as they proved false."""
        for a, b in [pair.ends for pair in pairs]:
            for table in (self.by_number, self.supported):
                if b in table.get(a, {}):
                    del table[a][b], table[b][a]

    def are_unsupported(self, pairs: Sequence[MeasuredPair]) -> bool:
        """Whether other pairs say that these, which agree, put one place on another that looks alike."""
        if any(pair.is_next for pair in pairs):
            return False
        support = np.average([self._support[pair.ends] for pair in pairs], weights=[pair.weight for pair in pairs])
        return bool(support < LEAST_SUPPORT)

    def have_other_colors(self, pairs: Sequence[MeasuredPair]) -> bool:
        """Whether pictures that pairs put on each other differ far more in colour than pictures so far apart do: enough
        where no third picture shows what both do, so that there are no triangles."""
        usual = self.usual_colors.at([pair.separation for pair in pairs])
        excess = float(np.mean([pair.other_colors for pair in pairs])) / float(usual.mean())
        return excess > FEW_TIMES * self._max_color_excess

    def vote(self, pair: MeasuredPair) -> float:
        """How much a pair counts beside others that say otherwise: 1 where nothing speaks for it or against it, hardly
        anything where it is all but unsupported, twice as much where as much speaks for it."""
        if pair.is_next:
            return MOST_VOTE
        return float(np.clip(1 - self._support[pair.ends] / LEAST_SUPPORT, LEAST_VOTE, MOST_VOTE))
