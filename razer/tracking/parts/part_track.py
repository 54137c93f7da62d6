"""Part of a tracked thing: a track of its own, and the cells that it holds within the whole."""

from __future__ import annotations

from collections import defaultdict

from razer.arrays import Int64Array
from razer.config import MapperConfig
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.evidence.view_consensus import MIN_VISIBLE_CELLS
from razer.tracking.parts.cell_votes import CellVotes, rows_in
from razer.tracking.track import Track

# A frame that says nothing new still shows where a part found in it lies.
_LEAST_WEIGHT = 1e-3


class PartTrack:
    """A part being mapped: `track`, its embeddings, views and the evidence that it exists; `votes`, its cells;
    `owners`, in how many frames its detections were given to each track, which is not its whole as long as the tracker
    takes it for a thing of its own; `nested` and `beside`, the views in which its mask lay in one of its whole, and in
    which its whole had another mask that it did not lie in."""

    def __init__(
        self, number: int, detection: Detection, frame_index: int, config: MapperConfig, scale: SimilarityScale
    ) -> None:
        """A part that a detection shows for the first time; `number` tells it from all others."""
        self.track = Track(number, detection, frame_index, config.bank, scale, config.maintenance)
        self.votes = CellVotes()
        self.owners: dict[int, int] = defaultdict(int)
        self.nested = self.beside = 0.0
        self._own = self.votes.own

    def observe(self, detection: Detection, frame_index: int, novelty: float) -> None:
        """Take in a later frame that shows it."""
        self.track.observe(detection, frame_index, novelty)
        self.track.count_hit(detection.score, novelty)

    def vote(self, in_mask: Int64Array, observed: Int64Array, novelty: float, owner: int) -> None:
        """Take in where a frame that is this share of a view shows it: the keys of the cells of its mask, and of all;
        `owner`, the track that was given the mask."""
        self.votes.add(in_mask, observed, max(novelty, _LEAST_WEIGHT))
        self._own = self.votes.own
        self.owners[owner] += 1

    def rename_owner(self, gone: int, survivor: int) -> None:
        """Note that a track was fused into another, or forgotten (survivor 0)."""
        count = self.owners.pop(gone, 0)
        if survivor and count:
            self.owners[survivor] += count

    def visible(self, observed: Int64Array) -> Int64Array:
        """The keys of its own cells that a frame shows."""
        return self._own[rows_in(observed, self._own)[1]]

    def visible_iou(self, in_mask: Int64Array, visible: Int64Array) -> float:
        """IoU of a mask with what the same frame shows of the part, both as keys of cells; those never seen near the
        part, as depth noise gives new ones in each view, count for neither side. 0 where next to nothing is shared."""
        shared = int(rows_in(in_mask, visible)[1].sum())
        if shared < MIN_VISIBLE_CELLS:
            return 0.0
        return shared / (self.votes.n_known(in_mask) + len(visible) - shared)

    def cell_iou(self, other: PartTrack) -> float:
        """IoU of the cells of both."""
        shared = int(rows_in(self._own, other._own)[1].sum())
        return shared / max(len(self._own) + len(other._own) - shared, 1)

    @property
    def owner(self) -> int:
        """The track that most of its masks were given to; 0 = none that there still is."""
        return min(self.owners, key=lambda i: (-self.owners[i], i), default=0)

    def absorb(self, other: PartTrack) -> None:
        """Become one with a double."""
        self.track.absorb(other.track)
        self.votes.absorb(other.votes)
        self._own = self.votes.own
        self.nested, self.beside = self.nested + other.nested, self.beside + other.beside
        for owner, count in other.owners.items():
            self.owners[owner] += count
