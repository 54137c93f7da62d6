"""Counts of pairs of tracks, indexed by each of the two, so that a fusion looks at the pairs of one track only."""

from __future__ import annotations

from collections import defaultdict

Pair = tuple[int, int]


class PairCounts(dict[Pair, float]):
    """{(lower id, higher id): count}; 0 where nothing was counted."""

    def __init__(self) -> None:
        super().__init__()
        self._others: dict[int, set[int]] = defaultdict(set)

    def __getstate__(self) -> dict[Pair, float]:
        return dict(self)

    def __setstate__(self, counts: dict[Pair, float]) -> None:
        self.__init__()  # type: ignore[misc]
        for pair, count in counts.items():
            self[pair] = count

    def __missing__(self, pair: Pair) -> float:
        return 0

    def __setitem__(self, pair: Pair, count: float) -> None:
        super().__setitem__(pair, count)
        a, b = pair
        self._others[a].add(b)
        self._others[b].add(a)

    def pairs_of(self, track_id: int) -> list[Pair]:
        """The pairs that a track is one of."""
        return [(min(track_id, other), max(track_id, other)) for other in sorted(self._others.get(track_id, ()))]

    def replace(self, gone: int, survivor: int) -> None:
        """Give the counts of one track to another, or forget them (survivor 0)."""
        for other in sorted(self._others.pop(gone, ())):
            self._others[other].discard(gone)
            count = self.pop((min(other, gone), max(other, gone)))
            if survivor and other != survivor:
                self[min(other, survivor), max(other, survivor)] += count
