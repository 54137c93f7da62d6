"""What is true of a scene: its surface as labelled points, and which of them a recording could see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_tools.furniture import Thing
from data_tools.tessellation import tessellate
from data_tools.visibility import Vantage, View, seen_often

MIN_VIEWS = 3


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """A labelled surface: vertices (V, 3) float32 in metres, triangles (T, 3) int32, instances (V,) int32 with
    ids >= 1, classes (V,) int32 with class_names naming them, visible (V,) bool: seen often enough to count."""

    vertices: NDArray[np.float32]
    triangles: NDArray[np.int32]
    instances: NDArray[np.int32]
    classes: NDArray[np.int32]
    class_names: Mapping[int, str]
    visible: NDArray[np.bool_]

    def __post_init__(self) -> None:
        count = len(self.vertices)
        if not count == len(self.instances) == len(self.classes) == len(self.visible):
            raise ValueError("a ground truth needs one instance, class and visibility for each vertex")

    @property
    def instance_classes(self) -> dict[int, str]:
        """The class name of each instance id."""
        ids, first = np.unique(self.instances, return_index=True)
        return {int(i): self.class_names[int(c)] for i, c in zip(ids, self.classes[first], strict=True)}


def ground_truth(
    things: Mapping[int, Thing],
    vantages: Sequence[Vantage],
    view: View,
    spacing_m: float = 0.01,
    first_seen: Mapping[int, int] | None = None,
) -> GroundTruth:
    """The surface of things (instance id -> Thing) every spacing_m metres; visible = seen in at least MIN_VIEWS
    vantages, counted for the instances in first_seen from that shot on (they stood elsewhere before)."""
    surface = tessellate(things, spacing_m)
    names = sorted({thing.class_name for thing in things.values()})
    class_of, since = np.zeros((2, max(things) + 1), np.int64)
    for number, thing in things.items():
        class_of[number] = names.index(thing.class_name) + 1
        since[number] = (first_seen or {}).get(number, 0)
    return GroundTruth(
        surface.vertices.astype(np.float32),
        surface.triangles,
        surface.instances,
        class_of[surface.instances].astype(np.int32),
        dict(enumerate(names, start=1)),
        seen_often(surface, vantages, view, MIN_VIEWS, since[surface.instances]),
    )
