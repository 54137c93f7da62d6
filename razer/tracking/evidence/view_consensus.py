"""View consensus on duplicates: two tracks that one mask covers, view after view, are duplicates or fragments.

A single mask may join what does not belong together, and a single frame may split what does. Each view in which both
tracks lie in one mask, or in two of which one is a part of the other, speaks for one thing, each in which they lie in
two beside each other against it: their log-odds add up, and those
of the embeddings are added by the `Tracker`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import combinations

from razer.tracking.evidence.pair_counts import Pair, PairCounts
from razer.tracking.label_overlap import LabelOverlap

COVERED = 0.5  # share of a track's visible cells that a mask must hold to count as its mask
MIN_VISIBLE_CELLS = 6  # fewer cells in view say nothing
# Natural logarithms of P(one mask | one thing) / P(one mask | two things), and of the same for two masks: a segmenter
# splits about one thing in ten, and joins a pair of neighbours about as often.
ONE_MASK_LOG_ODDS = 2.0
TWO_MASKS_LOG_ODDS = -2.0
# More is not said by masks alone: an error that a segmenter repeats in every view is no new evidence.
MAX_MASK_LOG_ODDS = 6.0


def nested_log_odds(nested: float, beside: float) -> float:
    """ln P(a part and its whole) / P(two things), from the views in which the one's mask lay within the other's, and
    those in which it lay beside it."""
    return min(ONE_MASK_LOG_ODDS * nested + TWO_MASKS_LOG_ODDS * beside, MAX_MASK_LOG_ODDS)


class ViewConsensus:
    """For pairs of tracks: the log-odds that they are one thing, by the masks of the views so far."""

    def __init__(self) -> None:
        self._together = PairCounts()
        self._apart = PairCounts()

    def add(self, overlap: LabelOverlap, born: Mapping[int, int], novelty: float = 1.0) -> None:
        """Take in one frame; `born` gives the mask of each track that starts in it, `novelty` the share of a view that
        the frame is."""
        mask_of = self._covering_masks(overlap, born)
        for pair in combinations(sorted(mask_of), 2):
            masks = mask_of[pair[0]], mask_of[pair[1]]
            if masks[0] == masks[1] and masks[0] in overlap.stuff:
                continue  # a wall's mask covers the pictures that were missed: they are not one for that
            is_one = masks[0] == masks[1] or not overlap.nested.isdisjoint({masks, masks[::-1]})
            counts = self._together if is_one else self._apart
            counts[pair] += novelty

    @staticmethod
    def _covering_masks(overlap: LabelOverlap, born: Mapping[int, int]) -> dict[int, int]:
        """The mask of each track: that in which it was born, or the smallest of those that cover its visible part.
        Masks that hold the same of the map are one, whatever their order."""
        holds: dict[int, tuple[Pair, ...]] = defaultdict(tuple)
        for (mask, track), n in sorted(overlap.in_mask.items()):
            holds[mask] += ((track, n),)
        first: dict[tuple[Pair, ...], int] = {}
        same_as = {mask: first.setdefault(held, mask) for mask, held in holds.items()}
        best: dict[int, int] = {}
        for held in sorted(first, key=lambda held: (sum(n for _, n in held), held)):
            for track, n in held:
                if overlap.visible[track] >= MIN_VISIBLE_CELLS and n >= COVERED * overlap.visible[track]:
                    best.setdefault(track, first[held])
        return best | {track: same_as.get(mask, mask) for track, mask in born.items()}

    def log_odds(self, pair: Pair) -> float:
        """ln P(one thing) / P(two things) of a pair (older id, newer id), by its masks alone."""
        log_odds = ONE_MASK_LOG_ODDS * self._together.get(pair, 0) + TWO_MASKS_LOG_ODDS * self._apart.get(pair, 0)
        return min(log_odds, MAX_MASK_LOG_ODDS)

    def apart(self, overlap: LabelOverlap, mask_of: Mapping[int, int]) -> dict[int, list[int]]:
        """For each matched track the others that its mask covers, though more views hold them apart from it than
        together; `mask_of` gives the masks of tracks that were matched in this frame, which are none of those."""
        covering = self._covering_masks(overlap, {})
        track_of = {mask: track for track, mask in mask_of.items()}
        others: dict[int, list[int]] = defaultdict(list)
        for track, mask in sorted(covering.items()):
            owner = track_of.get(mask)
            if owner and track not in mask_of and self.log_odds((min(track, owner), max(track, owner))) < 0:
                others[owner].append(track)
        return others

    def candidates(self, min_log_odds: float, track_id: int = 0) -> Iterator[tuple[Pair, float]]:
        """Pairs (older id, newer id) that were in one mask and have so much for their being one thing, with their
        log-odds; all of them, or those of one track."""
        for pair in self._together.pairs_of(track_id) if track_id else self._together:
            if (log_odds := self.log_odds(pair)) >= min_log_odds:
                yield pair, log_odds

    def replace(self, gone: int, survivor: int) -> None:
        """Rename a track that was fused, or forget one (survivor 0)."""
        for counts in (self._together, self._apart):
            counts.replace(gone, survivor)
