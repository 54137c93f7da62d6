"""The ground truth of a synthetic world: its surface as labelled points, and which of them a recording could see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from data_tools.synthetic.shapes.thing import Thing
from data_tools.synthetic.truth.tessellation import tessellate
from data_tools.synthetic.truth.visibility import CameraView, Viewpoint, visible_vertices
from data_tools.truth.ground_truth import GroundTruth

MIN_VIEWS = 3


def ground_truth(
    things: Mapping[int, Thing],
    viewpoints: Sequence[Viewpoint],
    view: CameraView,
    spacing_m: float = 0.01,
    first_seen: Mapping[int, int] | None = None,
) -> GroundTruth:
    """The surface of things as labelled vertices; visible = in view of at least MIN_VIEWS viewpoints.

    Args:
        things: instance id -> Thing.
        viewpoints: the frames of the recording.
        view: the camera, and the depths at which it measures.
        spacing_m: between the vertices, metres.
        first_seen: by instance id, from which viewpoint on it stands where it is; None = all from the first.
    """
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
        visible_vertices(surface, viewpoints, view, MIN_VIEWS, since[surface.instances]),
    )
