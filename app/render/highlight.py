"""Image of a map in which the hits of a query are highlighted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.render.name_tags import write_names
from app.render.overview_image import render_from_above
from app.render.palette import instance_colors
from razer.arrays import Float64Array, Uint8Array
from razer.map_object import Hit
from razer.mesh.labelled_mesh import LabelledMesh

_GREY = 0.35  # how much of its brightness the rest of the map keeps beside white


def highlight_hits(
    mesh: LabelledMesh, up: Float64Array, hits: Sequence[Hit], width: int = 1600, height: int = 700
) -> Uint8Array:
    """RGB image (height, width, 3): left the map as coloured, right the hits in colour, numbered as ranked.

    Args:
        mesh: the labelled surface.
        up: (3,) the direction that is up in the world.
        hits: instances, best first.
        width: of the image, pixels.
        height: of the image, pixels.
    """
    rendering = render_from_above(mesh, up, width // 2, height)
    grey = 255 * (1 - _GREY) + _GREY * mesh.colors.mean(axis=1, keepdims=True).repeat(3, axis=1)
    is_hit = np.isin(mesh.instances, [hit.object.id for hit in hits])
    colors = np.where(is_hit[:, None], instance_colors(mesh.instances), grey).astype(np.uint8)
    panel = rendering.panel(colors, blend=False)
    write_names(panel, rendering.instances, _labels(hits))
    return np.concatenate([rendering.panel(mesh.colors, blend=True), panel], axis=1)


def _labels(hits: Sequence[Hit]) -> dict[int, str]:
    """Rank, class and score of each instance."""
    texts = (f"{rank} {hit.class_guess or ''} {hit.score:.2f}" for rank, hit in enumerate(hits, start=1))
    return {hit.object.id: text.replace("  ", " ") for hit, text in zip(hits, texts, strict=True)}
