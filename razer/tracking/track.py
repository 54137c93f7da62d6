"""Tracked object: the one long-lived thing that changes."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.boxes.oriented_box import SURFACE_TRIM, OrientedBox, PointMoments
from razer.class_votes import ClassVote, VoteCount, best_name
from razer.config import BankSettings, MaintenanceSettings
from razer.detection.best_views import BestView, best_views
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.evidence.existence import Existence

# Share by which the memory of rival masks follows the newest view: half a dozen views in a row convince it, a
# mask that falls apart for five does not.
RIVALRY_RATE = 0.1

TYPICAL_RATE = 0.2  # by which the typical size of its detections follows the newest view
DEFAULT_MAINTENANCE = MaintenanceSettings()
ENOUGH_OF_TYPICAL = 0.5  # of it in view is a full chance to be detected


class Track:
    """An instance being mapped: id >= 1, box, moments, embedding bank, its hits, and the evidence that it exists."""

    def __init__(
        self,
        track_id: int,
        detection: Detection,
        frame_index: int,
        bank: BankSettings,
        scale: SimilarityScale | None = None,
        maintenance: MaintenanceSettings = DEFAULT_MAINTENANCE,
    ) -> None:
        """A new track.

        Args:
            track_id: Positive, and never used before.
            detection: The first of it.
            frame_index: The frame that shows it.
            bank: Settings of its embedding bank.
            scale: Of the embedder's cosines, shared by all tracks; without one, similarities are cosines.
            maintenance: Whether it is tentative at first, and what its moments and box are taken from.
        """
        self.id = track_id
        self.is_stuff = detection.is_stuff
        self.moments: PointMoments = detection.moments
        self.box: OrientedBox = detection.box
        self.bank = EmbeddingBank(bank, len(detection.embedding), scale)
        self.first_frame = self.last_frame = frame_index
        self.hits = 1
        self.existence = Existence(detection.score)
        self.won_share = 1.0
        self.n_voxels = 0
        self.views: tuple[BestView, ...] = ()
        self._rivalry = 0.0
        self._settings = maintenance
        self._typical_cells = float(detection.n_cells)
        self._votes = VoteCount()
        self.observe(detection, frame_index, 1.0)

    @property
    def class_name(self) -> str | None:
        """The name that the best observations carried, if the models name what they find: by sides and scores, each by
        the quality of the view, and by how far its embedding agrees with those before (`razer.class_votes`)."""
        return best_name(self.class_votes)

    @property
    def class_votes(self) -> tuple[ClassVote, ...]:
        """What it was called, from which side."""
        return self._votes.votes()

    @property
    def confirmed(self) -> bool:
        """Whether it is an instance: more likely a thing than a phantom, where tracks are tentative at all."""
        return not self._settings.tentative or self.existence.log_odds >= 0

    @property
    def confidence(self) -> float:
        """alpha in [0, 1]: the probability that it is a thing (temporal consistency), times that of its label being its
        own, the share of its votes that won their voxels."""
        return self.existence.probability * self.won_share

    @property
    def is_contested(self) -> bool:
        """Whether two masks have lain on this track for so long that it is hardly one thing."""
        return self._rivalry > 0.5

    def note_rival(self, has_rival: bool, novelty: float) -> None:
        """Take in whether a second mask claimed part of the track in a frame in which it was matched."""
        self._rivalry += novelty * RIVALRY_RATE * (has_rival - self._rivalry)

    def observe(self, detection: Detection, frame_index: int, novelty: float) -> None:
        """Update with a matched detection of a frame that is this share of a view: its box may grow (RAZER eqs. 9 to
        11)."""
        is_first = not len(self.bank.confidences)
        self.first_frame = min(self.first_frame, frame_index)  # a late frame was taken before those mapped already
        self.last_frame = max(self.last_frame, frame_index)
        self._typical_cells += novelty * TYPICAL_RATE * (detection.n_cells - self._typical_cells)
        if not is_first:
            self.moments = self.moments + detection.moments
            self._grow(detection.box)
        looks_like_itself = 1.0 if is_first else self.bank.probability_same(detection.embedding)
        self.bank.add(detection.embedding, detection.quality)
        if detection.region is not None:
            self.views = best_views([*self.views, BestView(frame_index, detection.region)])
        if detection.class_name is not None:
            weight = detection.quality * looks_like_itself
            self._votes.add(detection.class_name, detection.sector, weight, detection.score)

    def count_hit(self, score: float, novelty: float) -> None:
        """Note a later frame in which it was detected; an unsure detection is in part a miss."""
        self.hits += 1
        self.existence.count(novelty * score, novelty * (1 - score))

    def count_miss(self, visible_cells: int, novelty: float) -> None:
        """Note a frame that shows so many of its own cells, and no detection of it. Where much less of it is in view
        than usually is detected of it, or than it owns, it is the less missed."""
        typical_cells = min(self._typical_cells, self.n_voxels or np.inf)
        chance = min(1.0, visible_cells / max(1.0, ENOUGH_OF_TYPICAL * typical_cells))
        self.existence.count(0.0, novelty * chance)

    def refresh(self, points: Float64Array) -> None:
        """Count the track's own voxels (N, 3), and take moments and box from them, which forget what was corrected
        since, unless moments are sums."""
        self.n_voxels = len(points)
        if len(points) >= 4 and self._settings.moments == "voxels":
            self.moments = PointMoments.of(points)
            self.box = OrientedBox.around(points, self.moments.axes, SURFACE_TRIM)

    def absorb(self, other: Track) -> None:
        """Become one with a duplicate, which is then forgotten."""
        self.moments = self.moments + other.moments
        self._grow(other.box)
        self.bank.absorb(other.bank)
        self.first_frame = min(self.first_frame, other.first_frame)
        self.last_frame = max(self.last_frame, other.last_frame)
        self.hits = max(self.hits, other.hits)
        self._rivalry = max(self._rivalry, other._rivalry)
        self._typical_cells = max(self._typical_cells, other._typical_cells)
        self.existence.absorb(other.existence)
        self.n_voxels += other.n_voxels
        self.views = best_views([*self.views, *other.views])
        self._votes.absorb(other._votes)

    def _grow(self, other: OrientedBox) -> None:
        """Renew the box after the moments: where they are sums it follows from them, else it holds the other too."""
        if self._settings.moments == "sums":
            self.box = OrientedBox.of_moments(self.moments)
        else:
            self.box = _grown_to(self.box, self.moments, other)


def _grown_to(box: OrientedBox, moments: PointMoments, other: OrientedBox) -> OrientedBox:
    """A box along the moments' axes that holds both boxes: running bounds between refreshes."""
    return OrientedBox.around(np.concatenate([box.corners(), other.corners()]), moments.axes)
