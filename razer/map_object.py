"""One instance of a map, and what a query answers about instances."""

from __future__ import annotations

from dataclasses import dataclass, replace

from razer.arrays import Float32Array, Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.detection.best_views import BestView


@dataclass(frozen=True)
class MapObject:
    """One instance: id >= 1; score, the track's confidence alpha in [0, 1]; embeddings (J, D) float32 of unit
    length with weights (J,) adding up to 1; views, the frames that show it best, the best first; is_stuff, whether it
    is a surface that is not counted, such as a floor; class_votes, what it was called from which side; part_of, the id
    of its whole, None for wholes; is_edited, whether people changed it by hand; is_named_by_hand, whether its name is
    from them, and so certain."""

    id: int
    class_name: str | None
    score: float
    box: OrientedBox
    n_voxels: int
    n_vertices: int
    observations: int
    first_frame: int
    last_frame: int
    embeddings: Float32Array
    weights: Float64Array
    views: tuple[BestView, ...] = ()
    is_stuff: bool = False
    class_votes: tuple[ClassVote, ...] = ()
    part_of: int | None = None
    is_edited: bool = False
    is_named_by_hand: bool = False

    def on_surface(self, points: Float64Array) -> MapObject:
        """The same with its surface at `points` (N, 3), N >= 1, and voxels in proportion."""
        n_voxels = max(1, round(self.n_voxels * len(points) / max(self.n_vertices, 1)))
        return replace(self, box=OrientedBox.of_surface(points), n_vertices=len(points), n_voxels=n_voxels)


@dataclass(frozen=True)
class Hit:
    """An instance that a query means, with the probability that it does; class_guess, its class or else the nearest
    name. Where the query stood for several names: the one that it was found by (`through`), and the kind that this
    name belongs to, None if the name itself was asked for ("couch" as "seat"). runner_up: what else it may be, with
    the probability of that, if it is within reach."""

    object: MapObject
    score: float
    class_guess: str | None
    through: str | None = None
    kind: str | None = None
    runner_up: tuple[str, float] | None = None


@dataclass(frozen=True)
class Answer:
    """What a query found, the most probable first; nothing scores less than `threshold`."""

    hits: tuple[Hit, ...]
    threshold: float

    @property
    def found(self) -> bool:
        """Whether what was asked for is in the map at all."""
        return bool(self.hits)

    def best(self, k: int) -> Answer:
        """The same with the first k hits only."""
        return Answer(self.hits[:k], self.threshold)
