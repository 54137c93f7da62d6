"""Scenes of maps: what a picture of one shows and names, in each style."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.pictures.map_picture import Scene
from app.pictures.style_colors import is_stuff, style_colors
from app.pictures.view import Style
from razer.arrays import BoolArray
from razer.map_object import Hit, MapObject
from razer.panoptic_map import PanopticMap


def map_scene(panoptic: PanopticMap, style: Style) -> Scene:
    """A map in its own colours, by instance or by class, with the names of the largest things."""
    things = [item for item in panoptic.objects if not is_stuff(item)]
    return Scene(
        panoptic.mesh,
        style_colors(panoptic, style),
        panoptic.up_or_z,
        names_of(panoptic.objects),
        [item.id for item in things if item.class_name] or [item.id for item in things],
        ceilings(panoptic),
    )


def answer_scene(panoptic: PanopticMap, hits: Sequence[Hit]) -> Scene:
    """A map in pale grey with the hits of a query in colour, under their rank, name and probability."""
    numbers = [hit.object.id for hit in hits]
    mesh = panoptic.mesh_of(numbers)
    names = {hit.object.id: _hit_name(rank, hit) for rank, hit in enumerate(hits, start=1)}
    return Scene(mesh, style_colors(panoptic, "query", hits), panoptic.up_or_z, names, numbers, ceilings(panoptic))


def names_of(objects: Sequence[MapObject]) -> dict[int, str]:
    """The classes of instances that have one: of each kind of thing the largest, then the other things, then of each
    kind of stuff the largest; among these the largest first."""
    ranked = sorted((o for o in objects if o.class_name), key=lambda o: (-o.n_vertices, o.id))
    first: dict[str, MapObject] = {}
    for item in ranked:
        first.setdefault(str(item.class_name), item)
    things = [item for item in ranked if not is_stuff(item)]
    kinds = list(first.values())
    chosen = [item for item in kinds if not is_stuff(item)] + things + [item for item in kinds if is_stuff(item)]
    return {item.id: str(item.class_name) for item in chosen}


def ceilings(panoptic: PanopticMap) -> BoolArray | None:
    """Vertices (V,) of what is called ceiling, which hides the rest from above; None where nothing is."""
    called = [o.id for o in panoptic.objects if o.class_name and "ceiling" in o.class_name.lower() and is_stuff(o)]
    return np.isin(panoptic.mesh.instances, called) if called else None


def _hit_name(rank: int, hit: Hit) -> str:
    return " ".join(filter(None, (str(rank), hit.class_guess, f"{hit.score:.2f}")))
