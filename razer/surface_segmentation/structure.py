"""Planes of structure: which supervoxels are wall, floor or ceiling. What lies in such a plane but has another colour
hangs or lies on it: a picture, a door, a rug."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float64Array, Int64Array
from razer.surface_segmentation.level_planes import CEILING, FLOOR, level_plane
from razer.surface_segmentation.supervoxels import areas_m2, borders
from razer.surface_segmentation.surface import Surface, color_distance
from razer.surface_segmentation.wall_planes import wall_patches

STRUCTURE = ("", "wall", "floor", "ceiling")
"""What the numbers of `structure` mean."""
_MEMBER_SHARE = 0.5
_SAME_COLOR = 15.0  # Lab units from the plane's own colour
_MODE_ROUNDS = 3
_MAX_ROOMS = 12
_MIN_ROOM_M2 = 1.0
_RUG_OUTLINE = 0.35  # of a rug's outline at least borders on the floor round it; of a room's, doorways do


@dataclass(frozen=True)
class Pieces:
    """N supervoxels as structure looks at them: colors (N, 3) Lab, sizes (N,) vertices, areas (N,) square metres, and
    borders (B, 2), one for each edge of the mesh between two of them, both ways."""

    colors: Float64Array
    sizes: Int64Array
    areas: Float64Array
    borders: Int64Array

    @classmethod
    def of(cls, surface: Surface, supervoxel: Int64Array, colors: Float64Array) -> Pieces:
        """Those of a surface whose vertices (V,) name their supervoxel, -1 for none."""
        is_in, n = supervoxel >= 0, len(colors)
        ends = borders(surface, supervoxel)
        sizes, areas = np.bincount(supervoxel[is_in], minlength=n), areas_m2(surface, supervoxel, n)
        return cls(colors, sizes, areas, np.concatenate([ends, ends[:, ::-1]]))

    def inside(self, supervoxel: Int64Array, members: Int64Array) -> Int64Array:
        """The supervoxels of which most lies among some vertices (M,)."""
        of_plane = supervoxel[members]
        shares = np.bincount(of_plane[of_plane >= 0], minlength=len(self.sizes)) / np.maximum(self.sizes, 1)
        return np.flatnonzero(shares > _MEMBER_SHARE)

    def of_main_color(self, chosen: Int64Array) -> Int64Array:
        """Those of the chosen ones that have the colour of most of them."""
        color = _dominant_color(self.colors[chosen], self.sizes[chosen])
        return chosen[color_distance(self.colors[chosen], color) < _SAME_COLOR]


def structure(surface: Surface, supervoxel: Int64Array, colors: Float64Array) -> Int64Array:
    """What each of N supervoxels is, by its number in STRUCTURE; 0 for things.

    Args:
        surface: the surface.
        supervoxel: (V,) of each vertex, -1 for none.
        colors: (N, 3) their mean Lab colours.
    """
    pieces = Pieces.of(surface, supervoxel, colors)
    kinds = np.zeros(len(colors), np.int64)
    for patch in wall_patches(surface):
        inside = pieces.inside(supervoxel, patch.members)
        if len(inside):
            kinds[pieces.of_main_color(inside)] = STRUCTURE.index("wall")
    for name, facing in (("floor", FLOOR), ("ceiling", CEILING)):
        inside = pieces.inside(supervoxel, np.flatnonzero(level_plane(surface, facing)))
        kinds[_level_regions(pieces, inside)] = STRUCTURE.index(name)
    return kinds


def _level_regions(pieces: Pieces, inside: Int64Array) -> Int64Array:
    """Those supervoxels in a level plane that are the plane: of its main colour, and of the colours of other rooms,
    which unlike rugs hardly border on what is found already."""
    found = inside[:0]
    for _ in range(_MAX_ROOMS):
        if not len(inside):
            break
        alike = pieces.of_main_color(inside)
        inside = np.setdiff1d(inside, alike)
        found = np.concatenate([found, alike if not len(found) else _rooms(pieces, alike, found)])
    return found


def _rooms(pieces: Pieces, alike: Int64Array, found: Int64Array) -> Int64Array:
    """Of supervoxels of one colour those in connected regions that are large, and no rugs on `found`."""
    n = len(pieces.sizes)
    is_alike, is_found = np.isin(np.arange(n), alike), np.isin(np.arange(n), found)
    a, b = pieces.borders[is_alike[pieces.borders[:, 0]]].T
    within = is_alike[b]
    graph = coo_matrix((np.ones(within.sum()), (a[within], b[within])), (n, n))
    _, region = connected_components(graph, directed=False)
    outline = np.bincount(region[a[~within]], minlength=n)
    on_found = np.bincount(region[a[~within]], is_found[b[~within]], minlength=n)
    area = np.bincount(region[alike], pieces.areas[alike], minlength=n)
    is_room = (area >= _MIN_ROOM_M2) & (on_found < _RUG_OUTLINE * outline)
    return alike[is_room[region[alike]]]


def _dominant_color(colors: Float64Array, weights: Int64Array) -> Float64Array:
    """The mode (3,) of colours (N, 3): mean shift from their weighted median."""
    color = np.array([_weighted_median(channel, weights) for channel in colors.T])
    for _ in range(_MODE_ROUNDS):
        near = color_distance(colors, color) < _SAME_COLOR
        if near.any():
            color = np.average(colors[near], axis=0, weights=weights[near])
    return color


def _weighted_median(values: Float64Array, weights: Int64Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])
