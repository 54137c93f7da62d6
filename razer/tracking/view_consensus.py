"""View consensus on duplicates: two tracks that one mask covers, frame after frame, are duplicates or fragments.

A single mask may join what does not belong together, and a single frame may split what does. Over many views
the share of frames in which both tracks lie in one mask, among those in which both are clearly in some mask,
tells them apart (view consensus).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from itertools import combinations

from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.pair_counts import PairCounts

COVERED = 0.5  # share of a track's visible cells that a mask must hold to count as its mask
MIN_VISIBLE_CELLS = 12  # fewer cells in view say nothing


class ViewConsensus:
    """For pairs of tracks: frames in which one mask held both, and frames in which two masks did."""

    def __init__(self) -> None:
        self._together = PairCounts()
        self._apart = PairCounts()

    def add(self, overlap: LabelOverlap, born: Mapping[int, int]) -> None:
        """Take in one frame; `born` gives the mask of each track that starts in it."""
        mask_of = self._covering_masks(overlap) | dict(born)
        tracks_of: dict[int, list[int]] = defaultdict(list)
        for track in sorted(mask_of):
            tracks_of[mask_of[track]].append(track)
        for tracks in tracks_of.values():
            for pair in combinations(tracks, 2):
                self._together[pair] += 1
        for pair in combinations(sorted(mask_of), 2):
            if mask_of[pair[0]] != mask_of[pair[1]]:
                self._apart[pair] += 1

    @staticmethod
    def _covering_masks(overlap: LabelOverlap) -> dict[int, int]:
        """The mask that covers the visible part of a track, by track."""
        return {
            track: mask
            for (mask, track), n in sorted(overlap.in_mask.items())
            if overlap.visible[track] >= MIN_VISIBLE_CELLS and n >= COVERED * overlap.visible[track]
        }

    def agreed(self, min_frames: int, min_share: float, prior: float = 0.0) -> list[tuple[int, int]]:
        """Pairs (older id, newer id) that are one thing, those most often in one mask first; `prior` is how
        many frames in one mask a pair that has any is credited with beforehand."""
        agreed = []
        for pair, together in self._together.items():
            share = (together + prior) / (together + prior + self._apart.get(pair, 0))
            if together >= min_frames and share >= min_share:
                agreed.append((-together, -share, pair))
        return [pair for _, _, pair in sorted(agreed)]

    def replace(self, gone: int, survivor: int) -> None:
        """Rename a track that was fused, or forget one (survivor 0)."""
        for counts in (self._together, self._apart):
            counts.replace(gone, survivor)
