"""Which tracks are one thing: two tracks that one mask covers, frame after frame, are duplicates or fragments.

A single mask may join what does not belong together, and a single frame may split what does. Over many views
the share of frames in which both tracks lie in one mask, among those in which both are clearly in some mask,
tells them apart (view consensus).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from itertools import combinations

from razer.tracking.label_overlap import LabelOverlap

COVERED = 0.5  # share of a track's visible cells that a mask must hold to count as its mask
MIN_VISIBLE_CELLS = 12  # fewer cells in view say nothing


class Consensus:
    """For pairs of tracks: frames in which one mask held both, and frames in which two masks did."""

    def __init__(self) -> None:
        self._together: dict[tuple[int, int], int] = defaultdict(int)
        self._apart: dict[tuple[int, int], int] = defaultdict(int)

    def add(self, evidence: LabelOverlap, born: Mapping[int, int]) -> None:
        """Take in one frame; `born` gives the mask of each track that starts in it."""
        mask_of = {
            track: mask
            for (mask, track), n in sorted(evidence.in_mask.items())
            if evidence.visible[track] >= MIN_VISIBLE_CELLS and n >= COVERED * evidence.visible[track]
        }
        mask_of.update(born)
        tracks_of: dict[int, list[int]] = defaultdict(list)
        for track in sorted(mask_of):
            tracks_of[mask_of[track]].append(track)
        for tracks in tracks_of.values():
            for pair in combinations(tracks, 2):
                self._together[pair] += 1
        for pair in combinations(sorted(mask_of), 2):
            if mask_of[pair[0]] != mask_of[pair[1]]:
                self._apart[pair] += 1

    def agreed(self, min_frames: int, min_share: float, prior: float = 0.0) -> list[tuple[int, int]]:
        """Pairs (older id, newer id) that belong together, the surest first; `prior` is how many frames together a
        pair that ever was together is credited with beforehand."""
        found = []
        for pair, together in self._together.items():
            share = (together + prior) / (together + prior + self._apart.get(pair, 0))
            if together >= min_frames and share >= min_share:
                found.append((-together, -share, pair))
        return [pair for _, _, pair in sorted(found)]

    def replace(self, gone: int, survivor: int) -> None:
        """Rename a track that was fused, or forget one (survivor 0)."""
        for counts in (self._together, self._apart):
            for pair in [p for p in counts if gone in p]:
                n = counts.pop(pair)
                other = pair[0] if pair[1] == gone else pair[1]
                if survivor and other != survivor:
                    counts[min(other, survivor), max(other, survivor)] += n
