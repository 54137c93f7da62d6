"""Where the tabs of a run look from: at its map, down on its path, and at the things alone."""

from __future__ import annotations

import numpy as np

from app.render.viewpoint import Viewpoint, from_above, overview
from razer.arrays import Float64Array
from razer.mesh.labelled_mesh import LabelledMesh

MIDDLE_OF_MAP = 20, 80  # per cent of the surface, along each axis, that is in sight from above besides the path


def map_eyes(
    mesh: LabelledMesh, stuff: frozenset[int], world_from_camera: Float64Array, up: Float64Array | None
) -> list[Viewpoint]:
    """Where to look from: at the finished map, down on the path, and at the things.

    Args:
        mesh: the map, of which something is there.
        stuff: ids of the instances that are no things.
        world_from_camera: poses (N, 4, 4) of the cameras, N may be 0.
        up: (3,) of the map; None = that of the cameras.
    """
    points = mesh.vertices.astype(np.float64)
    of_things = points[~np.isin(mesh.instances, [0, *stuff])]
    poses = world_from_camera if len(world_from_camera) else np.eye(4)[None]
    upwards = -poses[:, :3, 1].mean(axis=0) if up is None else up
    forward = poses[:, :3, 2].mean(axis=0)
    objects = overview(of_things if len(of_things) else points, upwards, forward)
    above = np.concatenate([poses[:, :3, 3], np.percentile(points, MIDDLE_OF_MAP, axis=0)])
    return [overview(points, upwards, forward), from_above(above, upwards, forward), objects]
