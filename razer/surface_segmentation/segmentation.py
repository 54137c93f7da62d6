"""Segmentation of a fused surface: planes of structure first, the rest into supervoxels that merge to things."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from razer.arrays import Float64Array, Int32Array, Int64Array
from razer.config.surface_segmentation import SurfaceSegmentationSettings
from razer.mesh.labelled_mesh import LabelledMesh
from razer.surface_segmentation.merging import merged_things, wholeness
from razer.surface_segmentation.structure import STRUCTURE, structure
from razer.surface_segmentation.supervoxel_graph import AREA, supervoxel_graph, supervoxel_means
from razer.surface_segmentation.supervoxels import supervoxels
from razer.surface_segmentation.surface import Surface

_REACH_M = 0.1  # structure so far apart is connected: across what stands before it, and round corners
_MIN_STRUCTURE_M2 = 0.1
_STRUCTURE_SCORE = 0.95  # of what is called wall or floor so much is, in four scenes with truth


@dataclass(frozen=True)
class SurfaceSegments:
    """labels (V,) int32, the segment 1 .. S of each vertex, 0 = none; scores (S,) in [0, 1]; names (S,), of structure:
    wall, floor, ceiling; None for things."""

    labels: Int32Array
    scores: Float64Array
    names: tuple[str | None, ...]


def segment_surface(mesh: LabelledMesh, up: Float64Array, settings: SurfaceSegmentationSettings) -> SurfaceSegments:
    """Things and structure on a mesh, by its shape and colours alone.

    Args:
        mesh: the surface; its labels are not read.
        up: the world's upward direction (3,).
        settings: how fine.
    """
    nothing = SurfaceSegments(np.zeros(len(mesh.vertices), np.int32), np.zeros(0), ())
    if not len(mesh.triangles):
        return nothing
    surface = Surface.of(mesh, up)
    supervoxel, n = supervoxels(surface, settings.supervoxel_m)
    if n == 0:
        return nothing
    colors = supervoxel_means(surface.lab, supervoxel, n)
    kinds = structure(surface, supervoxel, colors)
    graph = supervoxel_graph(surface, supervoxel, colors, kinds == 0)
    graph = merged_things(graph, settings.merge_probability)
    whole = wholeness(graph)
    is_kept = (graph.sums[:, AREA] >= settings.min_area_m2) & (graph.sums[:, AREA] > 0) & (whole >= settings.min_score)
    number = np.cumsum(is_kept) * is_kept  # of regions, from 1
    labels = np.append(number[graph.region] * (kinds == 0), 0)[supervoxel]
    scores: list[float] = whole[is_kept].tolist()
    names: list[str | None] = [None] * len(scores)
    for kind in range(1, len(STRUCTURE)):
        for members in _pieces(surface, np.flatnonzero(np.append(kinds, 0)[supervoxel] == kind)):
            names.append(STRUCTURE[kind])
            scores.append(_STRUCTURE_SCORE)
            labels[members] = len(names)
    return SurfaceSegments(labels.astype(np.int32), np.array(scores, np.float64), tuple(names))


def structure_pieces(mesh: LabelledMesh, up: Float64Array, settings: SurfaceSegmentationSettings) -> list[Int64Array]:
    """The vertices of each connected plane of structure of a mesh: walls, floors, ceilings."""
    if not len(mesh.triangles):
        return []
    surface = Surface.of(mesh, up)
    supervoxel, n = supervoxels(surface, settings.supervoxel_m)
    kinds = np.append(structure(surface, supervoxel, supervoxel_means(surface.lab, supervoxel, n)), 0)[supervoxel]
    return [piece for kind in range(1, len(STRUCTURE)) for piece in _pieces(surface, np.flatnonzero(kinds == kind))]


def _pieces(surface: Surface, members: Int64Array) -> list[Int64Array]:
    """The connected parts of structure that are large enough; those that touch nearly are one."""
    if not len(members):
        return []
    cells, cell = np.unique(np.floor(surface.positions[members] / _REACH_M), axis=0, return_inverse=True)
    a, b = cKDTree(cells).query_pairs(np.sqrt(3) + 1e-6, output_type="ndarray").T
    _, part = connected_components(coo_matrix((np.ones(len(a)), (a, b)), (len(cells), len(cells))), directed=False)
    part = part[cell.reshape(-1)]
    areas = np.bincount(part, surface.areas[members])
    return [members[part == number] for number in np.flatnonzero(areas >= _MIN_STRUCTURE_M2)]
