"""Image of a map that was asked a question: in its colours, by instance with names, and the answer."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from app.render.highlight import highlight_hits
from app.render.name_tags import names_by_size
from app.render.overview_image import overview_image
from razer.arrays import Uint8Array
from razer.map_object import Hit
from razer.panoptic_map import PanopticMap

_PANEL = (640, 560)  # width and height, pixels
_CAPTION_PX = 30


def answer_image(panoptic: PanopticMap, question: str, hits: Sequence[Hit]) -> Uint8Array:
    """RGB image (590, 1920, 3) uint8: three views of the map under what each shows.

    Args:
        panoptic: the map.
        question: what it was asked for.
        hits: the answer, best first.
    """
    width, height = _PANEL
    up, names = panoptic.up_or_z, names_by_size(panoptic.objects)
    both = overview_image(panoptic.mesh, up, 2 * width, height, names)
    answer = highlight_hits(panoptic.mesh, up, hits, 2 * width, height)[:, width:]
    captions = np.full((_CAPTION_PX, 3 * width, 3), 255, np.uint8)
    for place, text in enumerate(("the map", "things and surfaces by name", f'asked for "{question}"')):
        origin = (place * width + 10, _CAPTION_PX - 9)
        cv2.putText(captions, text, origin, cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 1, cv2.LINE_AA)
    return np.concatenate([captions, np.concatenate([both, answer], axis=1)], axis=0)
