"""Pieces of the map that tracking does not connect, and when enough ties them together.

One view that fits somewhere is no proof: rooms repeat. A piece is tied where several views say the same, and few say
anything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from razer.geometry import Array, inverse
from slam.backend.pose_graph import Edge
from slam.se3 import angle_deg, length_m

MIN_WITNESSES = 3
MAJORITY = 2.0  # times as many witnesses as for any other place
SAME_M, SAME_DEG = 0.25, 5.0  # witnesses that differ by less say the same


@dataclass(frozen=True)
class Witness:
    """A view of one piece found in front of a keyframe of another: the edge between keyframes that follows, and
    where it puts the piece, home_from_piece (4, 4); `strength` orders witnesses that say the same."""

    frame: int
    edge: Edge
    home_from_piece: Array
    strength: float


@dataclass
class Ties:
    """What was witnessed about each pair of pieces (home < piece)."""

    _heard: dict[tuple[int, int], list[Witness]] = field(default_factory=dict)

    def hear(self, home: int, piece: int, witness: Witness) -> Sequence[Witness]:
        """Take in a witness; the agreeing witnesses, the strongest first, once they are enough to tie the two pieces
        together, else none."""
        heard = self._heard.setdefault((home, piece), [])
        heard.append(witness)
        agreeing = [other for other in heard if _agree(witness, other)]
        against = [other for other in heard if not _agree(witness, other)]
        rival = max((_voices([o for o in against if _agree(w, o)]) for w in against), default=0)
        if _voices(agreeing) < max(MIN_WITNESSES, MAJORITY * rival):
            return ()
        return sorted(agreeing, key=lambda other: -other.strength)

    def forget(self, piece: int) -> None:
        """The piece is no more: it became part of another."""
        self._heard = {pair: heard for pair, heard in self._heard.items() if piece not in pair}


def _agree(a: Witness, b: Witness) -> bool:
    off = inverse(a.home_from_piece) @ b.home_from_piece
    return length_m(off) <= SAME_M and angle_deg(off) <= SAME_DEG


def _voices(witnesses: Sequence[Witness]) -> int:
    """How many views they are: what one view sees in several keyframes, it sees once."""
    return len({witness.frame for witness in witnesses})
