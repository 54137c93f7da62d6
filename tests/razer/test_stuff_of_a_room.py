"""Stuff in a whole room: structure in pieces beside the things as they are."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig
from razer.frame import Frame, Masks
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.panoptic_map import PanopticMap

STRUCTURE = ("wall", "floor", "ceiling")


class PanopticOracle:
    """Things as they are, and the structure of a room by class, cut into two pieces at a column that changes."""

    def __init__(self) -> None:
        self.things = OracleSegmenter()

    def segment(self, frame: Frame) -> Masks:
        masks = self.things.segment(frame)
        names = masks.class_names or ()
        is_stuff = np.array([name in STRUCTURE for name in names])
        cut = 20 + 37 * frame.index % 120
        pieces, classes = [], []
        for name in STRUCTURE:
            whole = masks.masks[[n == name for n in names]].any(axis=0)
            left = whole.copy()
            left[:, cut:] = False
            for piece in (left, whole & ~left):
                if piece.any():
                    pieces.append(piece)
                    classes.append(name)
        things = masks.select(~is_stuff)
        return Masks(
            np.concatenate([things.masks, np.stack(pieces)]),
            np.concatenate([things.scores, np.full(len(pieces), 0.5, np.float32)]),
            (*(things.class_names or ()), *classes),
            np.repeat([False, True], [len(things), len(pieces)]),
        )


@pytest.fixture(scope="module")
def rooms() -> tuple[PanopticMap, PanopticMap]:
    """A room with things alone, and with its structure as stuff."""
    room, maps = SyntheticRoom(seed=0, n_frames=16, width=160, height=120), []
    for segmenter in (OracleSegmenter(), PanopticOracle()):
        mapper = Mapper(MapperConfig(), segmenter, OracleEmbedder("none"))
        for index in range(16):
            mapper.step(room[index])
        maps.append(mapper.finish())
    return maps[0], maps[1]


def test_a_room_has_one_surface_of_each_class(rooms: tuple[PanopticMap, PanopticMap]) -> None:
    """Walls that meet are one wall, cut as they may be; three by their own masks."""
    plain, panoptic = rooms
    stuff = [o for o in panoptic.objects if o.is_stuff]
    vertices = {name: sorted((o.n_vertices for o in stuff if o.class_name == name), reverse=True) for name in STRUCTURE}
    for name, counts in vertices.items():
        assert counts[0] > 0.98 * sum(counts), name
        # 9 % more of the floor, as none of it is taken for the background of the rest.
        assert counts[0] > 0.98 * sum(o.n_vertices for o in plain.objects if o.class_name == name), name
    assert sum(o.class_name == "wall" for o in plain.objects) > 1


def test_things_of_a_room_keep_their_surface_beside_stuff(rooms: tuple[PanopticMap, PanopticMap]) -> None:
    plain, panoptic = rooms
    things = [[o for o in m.objects if o.class_name not in STRUCTURE] for m in (plain, panoptic)]
    assert sorted(o.class_name or "" for o in things[0]) == sorted(o.class_name or "" for o in things[1])
    n_plain, n_panoptic = (sum(o.n_vertices for o in objects) for objects in things)
    assert n_panoptic == pytest.approx(n_plain, rel=0.03)
