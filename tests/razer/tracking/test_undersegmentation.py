"""Masks that join two things, told by the views before them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from razer.config import MaintenanceSettings, MapperConfig
from razer.tracking.step_result import Decision
from tests.support.cell_world import CellMask, CellWorld, rectangle

TABLE = CellMask(rectangle(0, 10, 0, 20), (1, 0, 0))
LAMP = CellMask(rectangle(2, 6, 2, 6), (0, 1, 0))
CHAIR = CellMask(rectangle(12, 18, 25, 35), (0, 0, 1))


def also_covered(decisions: Sequence[Decision]) -> dict[int, tuple[int, ...]]:
    return {d.track_id: d.spares for d in decisions}


def test_a_mask_that_joins_two_things_is_told_by_the_views_before_it() -> None:
    """A chair before a lamp: two masks in two views, then one over both, which is the chair's by its vector."""
    neighbour = CellMask(rectangle(12, 18, 35, 40), (0, 1, 0))
    joined = replace(CHAIR, cells=CHAIR.cells | neighbour.cells)
    world = CellWorld()
    for _ in range(2):
        assert also_covered(world.frame(CHAIR, neighbour)) == {1: (), 2: ()}
    decisions = world.frame(joined)
    assert also_covered(decisions) == {1: (2,)}
    # As often in one mask as in two: nobody knows.
    for _ in range(2):
        decisions = world.frame(joined)
    assert also_covered(decisions) == {1: ()}


def test_what_lies_on_a_thing_is_not_covered_besides() -> None:
    """A lamp's small mask covers little of the table, and the table's holds the lamp that has a mask of its own."""
    world = CellWorld()
    for _ in range(3):
        assert also_covered(world.frame(TABLE, LAMP)) == {1: (), 2: ()}
    hidden_in_part = [*LAMP.cells, *sorted(TABLE.cells)[:7]]
    assert also_covered(world.frame(LAMP, in_view=hidden_in_part)) == {2: ()}


def test_others_may_be_covered_unless_spared() -> None:
    both = replace(CHAIR, cells=CHAIR.cells | LAMP.cells)
    world = CellWorld(MapperConfig(maintenance=MaintenanceSettings(spare_others=False)))
    for _ in range(2):
        world.frame(CHAIR, LAMP)
    assert also_covered(world.frame(both)) == {1: ()}
