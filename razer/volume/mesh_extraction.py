"""Surface extraction by marching cubes, with the instance of each vertex. The only place, with `razer.storage`, where
attributes leave the device."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import Float32Array, Float64Array, IndexArray, Int32Array, Uint8Array
from razer.detection.observed_surface import Cells, cells_of
from razer.mesh.labelled_mesh import LabelledMesh
from razer.volume.marching_cubes import color_bytes, marching_cubes
from razer.volume.voxel_map import VoxelMap

# Neighbours of a vertex on the lattice, as x, y, z steps from its lower corner.
CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=np.int32)

LEAST_WEIGHT = 0.02  # of a corner of a lattice cube
POINTS_AT_ONCE = 20_000  # of votes around points, some 2 KB each


@dataclass(frozen=True)
class SurfacePoints:
    """Voxels that hold surface: positions (N, 3) float32 metres, colors (N, 3) uint8, instances (N,) int32."""

    positions: Float32Array
    colors: Uint8Array
    instances: Int32Array


def extract_points(voxels: VoxelMap, block_keys: Int32Array | None = None) -> SurfacePoints:
    """The voxels that hold the zero crossing, of the given blocks or of all, in a fixed order."""
    return points_at(voxels, voxels.surface_addresses(block_keys))


def points_at(voxels: VoxelMap, addresses: Tensor) -> SurfacePoints:
    """The voxels at addresses (N,)."""
    columns = (
        voxels.pages.positions(addresses),
        voxels.pages.read(addresses, "color")[0],
        voxels.resolve(voxels.pages.read(addresses, "label")[0][:, 0]),
    )
    positions, colors, instances = (column.cpu().numpy() for column in columns)
    return SurfacePoints(positions, color_bytes(colors / 255), instances)  # Open3D keeps colours as 0..255


def extract_mesh(voxels: VoxelMap) -> LabelledMesh:
    """Marching cubes with the label of each vertex; vertices sorted by position, each once, so that runs compare.

    Call `VoxelMap.settle` first where instances have been fused.
    """
    vertices, colors, triangles = marching_cubes(voxels.pages, voxels.settings)
    rank, order = _ranks(vertices, colors)
    vertices, colors = vertices[order], colors[order]
    triangles = rank[triangles]
    # Where surface meets a corner of the lattice, vertices of several edges are one, and triangles shrink to none.
    is_whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    triangles = _canonical(triangles[is_whole])
    by_votes = voxels.settings.vertex_labels == "votes"
    labels = vertex_labels(voxels, vertices) if by_votes else nearest_labels(voxels, vertices)
    labels = fill_seams(labels, triangles, voxels.settings.seam_rings)
    return LabelledMesh(vertices, colors, labels, triangles)


def extract_part(voxels: VoxelMap, block_keys: Int32Array) -> LabelledMesh:
    """The surface of those of some blocks (B, 3) that the map has, as quickly as it can be had: each vertex with the
    label of the voxel next to it, in no order."""
    known = block_keys[(voxels.pages.find(block_keys) >= 0).cpu().numpy()]
    vertices, colors, triangles = marching_cubes(voxels.pages, voxels.settings, known)
    return LabelledMesh(vertices, colors, nearest_labels(voxels, vertices), triangles)


def vertex_labels(voxels: VoxelMap, points: Float32Array) -> Int32Array:
    """The instance (V,) int32 with the most votes around each point: the voxels of the surrounding lattice cube
    add their votes, weighted as in trilinear interpolation; 0 where nobody voted."""
    size = voxels.settings.voxel_size_m
    result = [np.zeros(0, np.int32)]
    for part in np.array_split(points, len(points) // POINTS_AT_ONCE + 1):
        corners, weights = lattice_cubes(part, size)
        cells, row = cells_of(corners.reshape(-1, 3), size)
        result.append(_most_voted(voxels, cells, row.reshape(-1, 8), weights))
    return np.concatenate(result)


def lattice_cubes(points: Float32Array | Float64Array, size_m: float) -> tuple[Int32Array, NDArray]:
    """The corners (N, 8, 3) of the lattice cube around each point (N, 3), metres, and their weights (N, 8) in trilinear
    interpolation; none weighs nothing, as a point on an edge of the lattice sees the cells on both sides."""
    low = np.floor(points / size_m + 1e-4).astype(np.int32)
    inside = (points / size_m - low)[:, None]
    weights = np.where(CORNERS == 1, inside, 1 - inside).prod(axis=2)
    return low[:, None] + CORNERS, np.maximum(weights, LEAST_WEIGHT)


def nearest_labels(voxels: VoxelMap, points: Float32Array) -> Int32Array:
    """The label (V,) int32 of the voxel nearest to each point (RAZER section IV-H), 0 = nobody."""
    cells, row = cells_of(np.rint(points / voxels.settings.voxel_size_m).astype(np.int32), voxels.settings.voxel_size_m)
    return voxels.labels_at(cells).cpu().numpy()[row]


def fill_seams(labels: Int32Array, triangles: Int32Array, rings: int) -> Int32Array:
    """Labels (V,) in which nobody's vertices next to labelled ones are given to most of those neighbours.

    Masks are shrunk before they vote, which leaves seams of a voxel or two between instances and around them.
    """
    edges = _open_edges(labels, triangles)
    labels = labels.copy()
    for _ in range(rings):
        to_nobody = edges[(labels[edges[:, 0]] == 0) & (labels[edges[:, 1]] > 0)]
        claims, votes = np.unique(np.stack([to_nobody[:, 0], labels[to_nobody[:, 1]]]), axis=1, return_counts=True)
        # Written in this order, the claim with most votes comes last and stays; of equal ones the lowest id.
        order = np.lexsort((-claims[1], votes))
        labels[claims[0, order]] = claims[1, order]
    return labels


def _open_edges(labels: Int32Array, triangles: Int32Array) -> Int32Array:
    """Edges (E, 2) of triangles with nobody at the first end, each direction once; those that two instances hold never
    change, and are most."""
    parts = [triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))]
    half = np.concatenate([part[labels[part[:, 0]] == 0] for part in parts])
    key = np.unique(half[:, 0].astype(np.int64) * len(labels) + half[:, 1])
    return np.stack(np.divmod(key, max(len(labels), 1)), axis=1).astype(np.int32)


def _most_voted(voxels: VoxelMap, cells: Cells, corner: Int32Array, weights: NDArray) -> Int32Array:
    ids, counts = voxels.histograms_at(cells)
    row = torch.from_numpy(corner).to(ids.device).long()
    slots = ids.shape[1]
    near_ids = ids[row].reshape(len(corner), 8 * slots)
    # Whole numbers add up the same in any order.
    share = torch.from_numpy(np.rint(weights * 1024)).to(ids.device).long()
    near_votes = (counts[row] * share[:, :, None]).reshape(len(corner), 8 * slots)
    total = torch.zeros_like(near_votes)
    for slot in range(8 * slots):
        total[:, slot] = torch.where(near_ids == near_ids[:, slot, None], near_votes, 0).sum(dim=1)
    best = (total == total.max(dim=1, keepdim=True).values) & (near_votes > 0)
    lowest = torch.where(best, near_ids, torch.iinfo(torch.int32).max).min(dim=1).values
    return torch.where(best.any(dim=1), lowest, 0).cpu().numpy().astype(np.int32)


def _ranks(vertices: Float32Array, colors: Uint8Array) -> tuple[Int32Array, IndexArray]:
    """For each vertex (N, 3) the number of its position in their order, and for each position a vertex: of those at
    one place the one of the darkest colour."""
    shade = colors.astype(np.int32) @ np.array([2**16, 2**8, 1], np.int32)
    order = np.lexsort((shade, *vertices.T[::-1]))
    is_new = np.ones(len(order), bool)
    is_new[1:] = (vertices[order[1:]] != vertices[order[:-1]]).any(axis=1)
    rank = np.empty(len(order), np.int32)
    rank[order] = np.cumsum(is_new, dtype=np.int32) - 1
    return rank, order[is_new]


def _canonical(triangles: Int32Array) -> Int32Array:
    """Triangles with their lowest vertex first, winding kept, sorted."""
    first = triangles.argmin(axis=1)
    rolled = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    return rolled[np.lexsort(rolled.T[::-1])]
