"""R-tree of oriented boxes by their axis-aligned bounds (RAZER section IV-C); the only importer of rtree."""

from __future__ import annotations

import numpy as np
from rtree.index import Index, Property

from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox

# Boxes that moved less than this stay where they are in the tree: an update costs over a millisecond at 20,000.
SLACK_M = 0.02


class BoxIndex:
    """Track ids by the axis-aligned bounds of their boxes."""

    def __init__(self) -> None:
        self._tree = Index(properties=Property(dimension=3))
        self._bounds: dict[int, Float64Array] = {}

    def __getstate__(self) -> dict[int, Float64Array]:
        return self._bounds

    def __setstate__(self, bounds: dict[int, Float64Array]) -> None:
        self.__init__()  # type: ignore[misc]
        for track_id, of_track in bounds.items():
            self._tree.insert(track_id, of_track)
        self._bounds = bounds

    def put(self, track_id: int, box: OrientedBox) -> None:
        """Insert a box, or move it if it has moved by more than the slack."""
        bounds = box.enclosing_bounds()
        indexed = self._bounds.get(track_id)
        if indexed is not None:
            if np.abs(indexed - bounds).max() <= SLACK_M:
                return
            self._tree.delete(track_id, indexed)
        self._tree.insert(track_id, bounds)
        self._bounds[track_id] = bounds

    def drop(self, track_id: int) -> None:
        """Remove a box."""
        self._tree.delete(track_id, self._bounds.pop(track_id))

    def near(self, box: OrientedBox, margin_m: float) -> list[int]:
        """Ids, increasing, of the boxes whose bounds touch the given box grown by the margin."""
        return sorted(self._tree.intersection(box.enclosing_bounds(margin_m + SLACK_M)))
