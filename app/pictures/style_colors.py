"""What the vertices of a map look like in each style of picture: their own colours, instances, classes, hits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.pictures.label_drawing import Color
from app.pictures.view import Style
from app.render.palette import NOBODY, class_colors, colors_by_place
from razer.arrays import Float32Array, Uint8Array
from razer.map_object import Hit, MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.models.stuff_names import is_stuff_name
from razer.panoptic_map import PanopticMap

HIT = (226, 110, 38)
_PALE = (204, 206, 210)
_GRAIN = 0.45  # how much of their texture surfaces keep under a flat colour
_GRAIN_BOUNDS = (0.80, 1.15)
_QUIET_GRAIN = 0.25
_WEAKEST_HIT = 0.45  # share of its colour that the least probable hit keeps


@dataclass(frozen=True)
class VertexColors:
    """values (V, 3) float32 from 0 to 255; blends: whether they are interpolated within triangles, or have edges."""

    values: Float32Array
    blends: bool

    @classmethod
    def own(cls, mesh: LabelledMesh) -> VertexColors:
        """The colours that the camera saw."""
        return cls(mesh.colors.astype(np.float32), True)

    @classmethod
    def of_ids(cls, mesh: LabelledMesh, colors: dict[int, Color], rest: Sequence[int]) -> VertexColors:
        """A colour for each instance, and one for what has none; their texture shows through."""
        table = np.tile(np.asarray(rest, np.float32), (int(max([mesh.instances.max(initial=0), *colors])) + 1, 1))
        for number, color in colors.items():
            table[number] = color
        return cls(table[mesh.instances] * grain(mesh, _GRAIN), False)


def style_colors(panoptic: PanopticMap, style: Style, hits: Sequence[Hit] = ()) -> VertexColors:
    """The colours of a map's vertices, whose hits may be parts (`PanopticMap.mesh_of`)."""
    if style == "color":
        return VertexColors.own(panoptic.mesh)
    if style == "query":
        return _highlighted(panoptic.mesh_of([hit.object.id for hit in hits]), hits)
    ranked = _by_size(panoptic)
    groups = {stuff: [o for o in ranked if is_stuff(o) == stuff] for stuff in (False, True)}
    chosen = _instance_colors(groups) if style == "instance" else _class_colors(groups)
    return VertexColors.of_ids(panoptic.mesh, chosen, NOBODY)


def is_stuff(item: MapObject) -> bool:
    """Whether an instance is a surface that is not counted, by its masks or by its name."""
    return item.is_stuff or is_stuff_name(item.class_name or "")


def grain(mesh: LabelledMesh, share: float) -> Float32Array:
    """Factors (V, 1) that lay the brightness of a surface, relative to that of its instance, over a flat colour."""
    brightness = mesh.colors.astype(np.float32).mean(axis=1)
    owner = mesh.instances.clip(min=0)
    counts = np.bincount(owner, minlength=1).clip(min=1)
    mean = np.bincount(owner, brightness, len(counts)) / counts
    factor = 1 + share * (brightness - mean[owner]) / 128
    return factor.clip(*_GRAIN_BOUNDS).astype(np.float32)[:, None]


def _by_size(panoptic: PanopticMap) -> list[MapObject]:
    """Instances and parts, the largest first: as the page ranks them, so that both have the same colours."""
    return sorted([*panoptic.objects, *panoptic.parts], key=lambda each: (-each.n_vertices, each.id))


def _instance_colors(groups: dict[bool, list[MapObject]]) -> dict[int, Color]:
    chosen: dict[int, Color] = {}
    for stuff, members in groups.items():
        colors = colors_by_place(np.arange(len(members)), stuff).tolist()
        chosen |= {item.id: tuple(color) for item, color in zip(members, colors, strict=True)}
    return chosen


def _class_colors(groups: dict[bool, list[MapObject]]) -> dict[int, Color]:
    """By class; instances without one have none."""
    places: dict[str, int] = {}
    chosen = {}
    for stuff, members in groups.items():
        named = [item for item in members if item.class_name]
        for place, name in enumerate(dict.fromkeys(str(item.class_name) for item in named)):
            places.setdefault(name, place)
        for item in named:
            chosen[item.id] = tuple(class_colors(np.array([places[str(item.class_name)]]), stuff)[0].tolist())
    return chosen


def _highlighted(mesh: LabelledMesh, hits: Sequence[Hit]) -> VertexColors:
    """The hits in one colour, the paler the less probable they are beside the first; the rest in pale grey."""
    quiet = np.asarray(_PALE, np.float32) * grain(mesh, _QUIET_GRAIN)
    best = max((hit.score for hit in hits), default=1.0)
    weights = [_WEAKEST_HIT + (1 - _WEAKEST_HIT) * hit.score / max(best, 1e-6) for hit in hits]
    colors = {hit.object.id: _mixed(weight) for hit, weight in zip(hits, weights, strict=True)}
    shown = VertexColors.of_ids(mesh, colors, _PALE).values
    is_hit = np.isin(mesh.instances, list(colors))
    return VertexColors(np.where(is_hit[:, None], shown, quiet).astype(np.float32), False)


def _mixed(weight: float) -> Color:
    red, green, blue = (round(weight * a + (1 - weight) * b) for a, b in zip(HIT, _PALE, strict=True))
    return red, green, blue


def as_bytes(values: Float32Array) -> Uint8Array:
    """Values from 0 to 255, rounded and clipped."""
    return np.clip(values + 0.5, 0, 255).astype(np.uint8)
