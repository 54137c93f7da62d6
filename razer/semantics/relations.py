"""Spatial relations of instances, from their surfaces: on, in, under, against, next to.

Boxes only say which pairs to look at. *On* is what carries a thing (`supporting_surface`), *in* what encloses it
(`containment`), *against* the wall that it stands at or hangs on, *under* what covers it, *next to* what else stands
near by on the same support. A pair has the first of these that holds; a thing and its double have none (`doubles`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from razer.boxes.rtree_index import BoxIndex
from razer.semantics.containment import HEADROOM_M, TOUCH_M, covered, covering, is_in
from razer.semantics.doubles import is_double
from razer.semantics.supporting_surface import NOBODY, SupportingSurfaces
from razer.semantics.upright_instance import UprightInstance
from razer.semantics.wall_contact import is_against

RelationKind = Literal["on", "in", "under", "against", "next to"]

FAR_M = HEADROOM_M  # nothing is related to what is farther away
NEAR_M = 0.3  # things farther apart than this do not stand next to each other
_COVERED = 0.7
_SHARED_HEIGHT = 0.3


@dataclass(frozen=True, slots=True)
class Relation:
    """`source` is e.g. on `target`, ids both; distance_m between their surfaces."""

    source: int
    target: int
    relation: RelationKind
    distance_m: float


def relations(instances: Sequence[UprightInstance], background: UprightInstance | None = None) -> list[Relation]:
    """All relations, by source and target; of a pair that is merely next to each other the lower id is the source.

    Args:
        instances: with ids >= 1.
        background: the surface that belongs to none of them, of id 0: it carries things, too.
    """
    return sorted(_Scene(instances, background).relations(), key=lambda edge: (edge.source, edge.target))


class _Scene:
    """The instances, which of them are near each other, and what carries and holds each."""

    def __init__(self, instances: Sequence[UprightInstance], background: UprightInstance | None) -> None:
        self._by_id = {instance.id: instance for instance in instances}
        self._index = BoxIndex()
        for instance in instances:
            self._index.put(instance.id, instance.box)
        self._has_stuff = any(instance.stuff for instance in instances)
        self._has_floor = any(instance.stuff and not instance.is_wall for instance in instances)
        things = [instance for instance in instances if not instance.stuff]
        surfaces = SupportingSurfaces(instances, background)
        self._supporter = _supporters(things, surfaces)
        self._container = {thing.id: self._smallest_container(thing) for thing in things}

    def relations(self) -> Iterator[Relation]:
        """One for each pair that has any."""
        pairs = {(one.id, other.id) for one in self._by_id.values() for other in self._near(one)}
        # A floor that is hidden behind furniture is seen farther away, and carries all the same.
        pairs |= {(thing, carrier) for thing, carrier in self._supporter.items() if carrier in self._by_id}
        for first, second in sorted({(min(pair), max(pair)) for pair in pairs}):
            one, other = self._by_id[first], self._by_id[second]
            if not (one.stuff and other.stuff) and not is_double(one, other):
                yield from self._between(one, other)

    def _near(self, one: UprightInstance) -> list[UprightInstance]:
        near = self._index.near(one.box, max(NEAR_M, HEADROOM_M))
        return [self._by_id[number] for number in near if number != one.id]

    def _smallest_container(self, thing: UprightInstance) -> int | None:
        supporter = self._supporter[thing.id]
        around = [other for other in self._near(thing) if not other.stuff and not is_double(thing, other)]
        holding = [other for other in around if is_in(thing, other, supporter)]
        return min(holding, key=lambda other: other.box.volume).id if holding else None

    def _between(self, one: UprightInstance, other: UprightInstance) -> list[Relation]:
        for relate in (self._carried, self._against, self._under):
            for source, target in ((one, other), (other, one)):
                if not source.stuff and (relation := relate(source, target)):
                    return [Relation(source.id, target.id, relation, _distance_m(one, other))]
        # Most pairs are of a thing and a wall across the room, whose distance takes longest to find: it is asked last.
        if not self._is_beside(one, other) or (distance_m := _distance_m(one, other)) > NEAR_M:
            return []
        return [Relation(one.id, other.id, "next to", distance_m)]

    def _carried(self, source: UprightInstance, target: UprightInstance) -> RelationKind | None:
        container = self._container[source.id]
        if container is not None:
            return "in" if container == target.id else None
        return "on" if self._supporter[source.id] == target.id else None

    def _against(self, source: UprightInstance, target: UprightInstance) -> RelationKind | None:
        """Only what stands on the floor or hangs: a book on a shelf is not against the wall behind both."""
        may_be_wall = target.stuff or (target.is_sheet and not self._has_stuff)
        if not may_be_wall or self._is_on_thing(source):
            return None
        return "against" if is_against(source, target) else None

    def _is_on_thing(self, source: UprightInstance) -> bool:
        supporter = self._supporter[source.id]
        if supporter == NOBODY:  # where floors are known nobody's surface is that of furniture
            return self._has_floor
        is_on_furniture = supporter is not None and not self._by_id[supporter].stuff
        return self._container[source.id] is not None or is_on_furniture

    def _under(self, source: UprightInstance, target: UprightInstance) -> RelationKind | None:
        if target.stuff or target.is_wall or (source.name and source.name == target.name):
            return None
        if covered(source, target) < _COVERED:
            return None
        height = float(np.median(covering(source, target)[:, 2]))
        others = [other for other in self._near(source) if other.id != target.id]
        return None if any(_is_between(source, other, height) for other in others) else "under"

    def _is_beside(self, one: UprightInstance, other: UprightInstance) -> bool:
        """Whether they stand on the same thing, or on nothing known, at the same height, with no wall between."""
        if one.stuff or other.stuff or self._supporter[one.id] != self._supporter[other.id]:
            return False
        if one.name == other.name != "" and self._supporter[one.id] is None and not (one.is_sheet and other.is_sheet):
            return False  # what floats beside a thing of its class is a piece of it
        walls = [wall for wall in self._near(one) if wall.stuff]
        return _same_level(one, other) and not any(_is_parted(one, other, wall) for wall in walls)


def _supporters(things: Sequence[UprightInstance], surfaces: SupportingSurfaces) -> dict[int, int | None]:
    """What carries each; what stands on a thing and reaches less low than it does not carry it in turn."""
    supporter = {thing.id: surfaces.supporter(thing) for thing in things}
    for thing in things:
        low = float(thing.bounds[0, 2])
        riders = {one.id for one in things if supporter[one.id] == thing.id and float(one.bounds[0, 2]) > low}
        if supporter[thing.id] in riders:
            supporter[thing.id] = surfaces.supporter(thing, riders)
    return supporter


def _is_between(source: UprightInstance, other: UprightInstance, height: float) -> bool:
    """Whether `other` covers `source` below a height."""
    over = covering(source, other)
    return bool(len(over)) and float(np.median(over[:, 2])) < height and covered(source, other) >= _COVERED / 2


def _is_parted(one: UprightInstance, other: UprightInstance, wall: UprightInstance) -> bool:
    """Whether a wall stands between the points at which two instances are nearest."""
    distances, rows = other.tree.query(one.sample, distance_upper_bound=FAR_M)
    nearest = int(distances.argmin())
    if not np.isfinite(distances[nearest]):
        return False  # only what the sample left out of a large instance is near
    ends = one.sample[nearest], other.points[rows[nearest]]
    between = np.linspace(*ends, 7)[1:-1]
    at_wall = np.isfinite(wall.tree.query(between, distance_upper_bound=TOUCH_M / 2)[0])
    return float(distances[nearest]) > TOUCH_M and bool(at_wall.any())


def _distance_m(one: UprightInstance, other: UprightInstance) -> float:
    few, many = sorted((one, other), key=lambda instance: len(instance.points))
    # What the sample of one is away from the other's sample bounds the search, which else takes most of the time.
    bound_m = float(many.coarse_tree.query(few.sample)[0].min())
    return min(bound_m, float(many.tree.query(few.sample, distance_upper_bound=bound_m)[0].min()))


def _same_level(one: UprightInstance, other: UprightInstance) -> bool:
    """Whether their heights overlap."""
    (low, _, high), (other_low, _, other_high) = one.heights_m, other.heights_m
    shared = min(high, other_high) - max(low, other_low)
    return shared >= _SHARED_HEIGHT * min(high - low, other_high - other_low)
