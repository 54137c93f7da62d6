"""A map of cells on a table top, counted cell by cell: what the volume does for the tracker, slowly and obviously."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import MapperConfig
from razer.detection.lifting import Detection
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.step_result import Decision
from razer.tracking.tracker import Tracker
from tests.support.scenes import detection, unit

WIDTH = 40  # cells in a row
CELL_M = 0.04


def rectangle(top: int, bottom: int, left: int, right: int) -> frozenset[int]:
    """Cells of rows top to bottom - 1 and columns left to right - 1."""
    return frozenset(row * WIDTH + column for row in range(top, bottom) for column in range(left, right))


def points_of(cells: Iterable[int]) -> np.ndarray:
    """Where cells lie (N, 3), metres; every other one a little raised, so that boxes have a volume."""
    rows, columns = np.divmod(np.array(sorted(cells)), WIDTH)
    return np.stack([columns, rows, (rows + columns) % 2], axis=1) * CELL_M


@dataclass(frozen=True)
class CellMask:
    """A mask by the cells it covers, with the vector and the score of what it shows; `stuff` is the class of stuff."""

    cells: frozenset[int]
    embedding: tuple[float, ...] = (1.0, 0.0)
    score: float = 0.9
    stuff: str | None = None

    def detection(self, mask: int) -> Detection:
        points = points_of(self.cells)
        moments = PointMoments.of(points)
        box = OrientedBox.around(points, moments.axes)
        of_thing = detection(box, unit(*self.embedding), cells=sorted(self.cells), mask=mask, score=self.score)
        return replace(of_thing, class_name=self.stuff, is_stuff=self.stuff is not None)


class CellWorld:
    """A tracker, and the votes of each cell."""

    def __init__(self, config: MapperConfig | None = None) -> None:
        self.tracker = Tracker(config or MapperConfig())
        self._votes: dict[int, Counter[int]] = defaultdict(Counter)
        self._last_vote: dict[int, int] = {}
        self._n_frames = 0

    def label(self, cell: int) -> int:
        """The track that owns a cell, of several with as many votes the last one voted for; 0 = nobody."""
        votes, last = self._votes[cell], self._last_vote.get(cell)
        return max(votes, key=lambda track_id: (votes[track_id], track_id == last), default=0)

    def owned(self, track_id: int) -> frozenset[int]:
        """The cells of a track."""
        return frozenset(cell for cell in self._votes if self.label(cell) == track_id)

    def overlap(self, masks: Sequence[CellMask], in_view: Iterable[int]) -> LabelOverlap:
        """What `LabelOverlap.gather` counts, one detection a mask."""
        visible = Counter(self.label(cell) for cell in in_view)
        shared = Counter((m, self.label(cell)) for m, mask in enumerate(masks) for cell in mask.cells)
        del visible[0]
        shared = Counter({key: n for key, n in shared.items() if key[1]})
        labelled: Counter[int] = Counter()
        for (m, _), n in shared.items():
            labelled[m] += n
        return LabelOverlap(dict(shared), dict(labelled), dict(visible), dict(shared))

    def frame(
        self,
        *masks: CellMask,
        in_view: Iterable[int] | None = None,
        index: int | None = None,
        novelty: float = 1.0,
        is_beside: bool = False,
    ) -> list[Decision]:
        """Map one frame, which sees all cells unless told, and renew the tracks' voxels."""
        self._n_frames += 1
        view = set(self._votes) if in_view is None else set(in_view)
        overlap = self.overlap(masks, view | {cell for mask in masks for cell in mask.cells})
        found = [mask.detection(m) for m, mask in enumerate(masks)]
        frame_index = self._n_frames if index is None else index
        decisions = self.tracker.update(found, overlap, frame_index, novelty, is_beside)
        painted = {}
        for m in sorted(range(len(masks)), key=lambda m: -len(masks[m].cells)):
            painted |= dict.fromkeys(masks[m].cells, decisions[m].track_id)
        for cell, track_id in painted.items():
            self._votes[cell][track_id] += 1
            self._last_vote[cell] = track_id
        self._refresh()
        return decisions

    def fuse(self) -> list[tuple[int, int]]:
        """Fuse duplicates, and give their votes to the survivors."""
        fused = self.tracker.fuse_duplicates()
        for gone, survivor in fused:
            for votes in self._votes.values():
                if n := votes.pop(gone, 0):
                    votes[survivor] += n
            self._last_vote = {c: survivor if t == gone else t for c, t in self._last_vote.items()}
        self._refresh()
        return fused

    def prune(self, *, spare_confirmed: bool = False) -> list[int]:
        """Prune tracks, and forget their votes."""
        return self._forget(self.tracker.prune(spare_confirmed=spare_confirmed))

    def drop_unconfirmed(self) -> list[int]:
        """Drop what is no instance, and forget its votes."""
        return self._forget(self.tracker.drop_unconfirmed())

    def erase(self, cells: Iterable[int]) -> None:
        """Surface that was carved away."""
        for cell in cells:
            self._votes.pop(cell, None)
        self._refresh()

    def _forget(self, gone: list[int]) -> list[int]:
        for votes in self._votes.values():
            for track_id in gone:
                votes.pop(track_id, None)
        return gone

    def _refresh(self) -> None:
        for track in self.tracker.tracks.values():
            points = points_of(self.owned(track.id))
            track.refresh(points)
            self.tracker.refreshed(track)
