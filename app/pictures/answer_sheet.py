"""Sheet of a map that was asked a question: in its colours, by instance with names, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from app.pictures.map_picture import draw
from app.pictures.scenes import answer_scene, map_scene
from app.pictures.view import View
from razer.arrays import Uint8Array
from razer.map_object import Hit
from razer.panoptic_map import PanopticMap

_PANEL = (800, 640)  # width and height, pixels
_CAPTION_PX, _TEXT_PX, _WEIGHT = 54, 22, 500
_INK = (38, 42, 48)


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
    panels = zip(captions, (own, named, answer), strict=True)
    return np.concatenate([np.concatenate([_caption(text), panel.pixels]) for text, panel in panels], axis=1)


def _caption(text: str) -> Uint8Array:
    strip = np.full((_CAPTION_PX, _PANEL[0], 3), 255, np.uint8)
    font = cv2.FontFace("sans")
    cv2.putText(strip, text, (round(0.6 * _TEXT_PX), _CAPTION_PX - _TEXT_PX // 2), _INK, font, _TEXT_PX, _WEIGHT)
    return strip
