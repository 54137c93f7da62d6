"""Arrangement: what was put on, into or against what, noted as things are placed; the truth of a world's relations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from data_tools.synthetic.shapes.thing import Thing

Triple = tuple[int, str, int]

# What holds things below its rim; shelves of these worlds are racks without sides, whose boards things stand on.
CONTAINERS = frozenset({"crate", "box", "basket", "laundry basket", "bucket", "trash can", "sink", "bathtub", "bowl"})
RIM_M = 0.05  # a rim that is lower keeps nothing in: what stands on a tray is on it
AGAINST_M = 0.05  # no hand fits between a wall and what stands or hangs against it


class Arrangement:
    """The things of a world by id >= 1, in the order in which they came, and how they were placed."""

    def __init__(self, things: Iterable[Thing] = ()) -> None:
        self.things: list[Thing] = list(things)
        self.relations: list[Triple] = []

    def stands(self, thing: Thing) -> None:
        """Note that a thing was put on the floor of the room it is in, perhaps against a wall."""
        floor = next((other for other in self.things if other.class_name == "floor" and _below(other, thing)), None)
        if floor is not None:
            self._note(thing, "on", floor)
        self.hangs(thing)

    def hangs(self, thing: Thing) -> None:
        """Note the walls that a thing was put against."""
        least, most = thing.bounds
        for wall in self._walls():
            begin, end = wall.bounds
            low, high = np.maximum(least, begin), np.minimum(most, end)
            across = int((end - begin)[:2].argmin())
            along = np.delete(high - low, across)
            if (along > 0).all() and low[across] - high[across] <= AGAINST_M:
                self._note(thing, "against", wall)

    def rests(self, thing: Thing, support: Thing, *, enclosed: bool = False) -> None:
        """Note that a thing was put on a support, or into it: below the rim of a container, or, if `enclosed`, into a
        case with sides and a back."""
        below_rim = float(support.bounds[1][2] - thing.bounds[0][2]) >= RIM_M
        is_in = enclosed or (support.class_name in CONTAINERS and below_rim)
        self._note(thing, "in" if is_in else "on", support)

    def _note(self, thing: Thing, relation: str, other: Thing) -> None:
        self.relations.append((self._number(thing), relation, self._number(other)))

    def _number(self, thing: Thing) -> int:
        return next(number for number, known in enumerate(self.things, start=1) if known is thing)

    def _walls(self) -> Iterator[Thing]:
        return (thing for thing in self.things if thing.class_name == "wall")


def _below(floor: Thing, thing: Thing) -> bool:
    middle = (thing.bounds[0] + thing.bounds[1])[:2] / 2
    return bool((middle >= floor.bounds[0][:2]).all() and (middle <= floor.bounds[1][:2]).all())
