"""Sheet of a map that was asked a question: in its colours, by instance with names, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from app.pictures.captions import captioned_row
from app.pictures.map_picture import draw
from app.pictures.scenes import answer_scene, map_scene
from app.pictures.view import View
from razer.arrays import Uint8Array
from razer.map_object import Hit
from razer.panoptic_map import PanopticMap

_PANEL = (800, 640)  # width and height, pixels


def answer_sheet(panoptic: PanopticMap, question: str, hits: Sequence[Hit]) -> Uint8Array:
    """RGB image (694, 2400, 3) uint8: three pictures of the map from one angle, under what each shows.

    Args:
        panoptic: the map.
        question: what it was asked for.
        hits: the answer, best first.
    """
    named = draw(map_scene(panoptic, "instance"), View(size=_PANEL))
    view = View(named.angle, _PANEL)
    own = draw(replace(map_scene(panoptic, "color"), names={}), view)
    answer = draw(answer_scene(panoptic, hits), view)
    captions = ("the map", "its things by name", f'asked for "{question}"')
    return captioned_row([(text, panel.pixels) for text, panel in zip(captions, (own, named, answer), strict=True)])
