"""A picture of a map in which the hits of a query stand out."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from app.render.palette import instance_colors
from app.render.picture import Sight, look_into
from razer.arrays import Float64Array, Uint8Array
from razer.map_object import Hit
from razer.volume.mesh_extraction import LabelledMesh

_GREY = 0.35  # how much of its brightness the rest of the map keeps beside white


def highlighted(
    mesh: LabelledMesh, up: Float64Array, hits: Sequence[Hit], width: int = 1600, height: int = 700
) -> Uint8Array:
    """RGB image (height, width, 3): left the map as coloured, right the hits in colour, numbered as ranked."""
    sight = look_into(mesh, up, width // 2, height)
    grey = 255 * (1 - _GREY) + _GREY * mesh.colors.mean(axis=1, keepdims=True).repeat(3, axis=1)
    hit = np.isin(mesh.instances, [h.object.id for h in hits])
    colors = np.where(hit[:, None], instance_colors(mesh.instances), grey).astype(np.uint8)
    panel = sight.panel(colors, blend=False)
    _write_labels(panel, sight, hits)
    return np.concatenate([sight.panel(mesh.colors, blend=True), panel], axis=1)


def _write_labels(panel: Uint8Array, sight: Sight, hits: Sequence[Hit]) -> None:
    seen = sight.instances
    for rank, hit in enumerate(hits, start=1):
        rows, columns = np.nonzero(seen == hit.object.id)
        if len(rows) == 0:
            continue
        place = (int(np.median(columns)), int(np.median(rows)))
        text = f"{rank} {hit.class_guess or ''} {hit.score:.2f}".replace("  ", " ")
        for color, thickness in (((255, 255, 255), 4), ((0, 0, 0), 1)):
            cv2.putText(panel, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, color, thickness, cv2.LINE_AA)
