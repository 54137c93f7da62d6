"""Compressed mesh of the page: positions on a lattice, colours of 7 bits, each as the difference from a guess.

A new vertex is guessed from the triangle that its own hangs on, positions as the fourth corner of a parallelogram
(Touma and Gotsman, 1998), the rest as the mean of the edge. viewer/src/mesh_decoder.ts undoes it in one pass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from app.page.packet import planes, zigzag
from app.page.traversal import Traversal, traverse
from razer.arrays import IntArray, Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh

QUANTUM_M = 0.0005  # spacing of the lattice of positions; 2^23 of them are four kilometres
COLOR_SHIFT = 1  # bits of colour left away
OCCLUSION_SHIFT = 3  # and of occlusion


@dataclass(frozen=True)
class EncodedMesh:
    """header: vertices, triangles, origin_m (3,), quantum_m, color_shift, occlusion_shift, and `ids` (K,), the
    instances, 0 for nobody, that the mesh names by their place among them; sections by name."""

    header: dict[str, Any]
    sections: dict[str, bytes]


def encode_mesh(
    mesh: LabelledMesh, occlusion: Uint8Array | None = None, prefix: str = "", order: Traversal | None = None
) -> EncodedMesh:
    """A mesh in few bytes; vertices of no triangle are left out.

    Args:
        mesh: the mesh.
        occlusion: (V,) how open each vertex lies, 255 = not occluded at all; None: nothing is.
        prefix: of the sections' names.
        order: that of its triangles, where it is known.
    """
    order = traverse(mesh.triangles) if order is None else order
    guesses = _guesses(order)
    vertices = order.vertices
    occlusion = np.full(len(mesh.vertices), 255, np.uint8) if occlusion is None else occlusion
    origin = mesh.vertices.min(axis=0).astype(np.float64) if len(mesh.vertices) else np.zeros(3)
    lattice = np.rint((mesh.vertices[vertices] - origin) / QUANTUM_M).astype(np.int64)
    ids, slots = np.unique(mesh.instances[vertices], return_inverse=True)
    colors = mesh.colors[vertices].astype(np.int64) >> COLOR_SHIFT
    sections = {
        **_connectivity(order),
        **_positions(lattice, guesses),
        **_colors(colors, guesses),
        **_slots(slots.reshape(-1), guesses),
        "occlusion": planes(_from_mean(occlusion[vertices].astype(np.int64) >> OCCLUSION_SHIFT, guesses), 1),
    }
    header = {
        "vertices": len(vertices),
        "triangles": len(mesh.triangles),
        "origin_m": origin.tolist(),
        "quantum_m": QUANTUM_M,
        "color_shift": COLOR_SHIFT,
        "occlusion_shift": OCCLUSION_SHIFT,
        "ids": ids.tolist(),
    }
    return EncodedMesh(header, {prefix + name: content for name, content in sections.items()})


def _guesses(order: Traversal) -> IntArray:
    """For each vertex (V, 3) the ends of the edge that its first triangle hangs on, and the corner across; three times
    the vertex before it where there is no such triangle, -1 for the very first."""
    result = np.repeat(np.arange(len(order.vertices))[:, None] - 1, 3, axis=1)
    triangle = np.flatnonzero(order.is_first[:, 2] & ~order.is_root)
    corners = order.corners[triangle]
    across = order.corners[order.parent[triangle]].sum(axis=1) - corners[:, 0] - corners[:, 1]
    result[corners[:, 2]] = np.stack([corners[:, 0], corners[:, 1], across], axis=1)
    return result


def _connectivity(order: Traversal) -> dict[str, bytes]:
    parents = order.parent[~order.is_root]
    written = np.repeat(order.is_root[:, None], 3, axis=1)
    written[:, 2] = True  # the other corners are those of the parent
    # How far back a vertex lies behind the one that would be new.
    seen = np.cumsum(order.is_first.reshape(-1)).reshape(-1, 3)
    back = (seen - order.corners)[written & ~order.is_first]
    return {
        "edge": planes(order.edge, 1),
        "parent_step": planes(np.diff(parents, prepend=0), 3),
        "is_new": np.packbits(order.is_first[written], bitorder="little").tobytes(),
        "back": planes(back, 3),
    }


def _positions(lattice: IntArray, guesses: IntArray) -> dict[str, bytes]:
    start, end, across = _at(lattice, guesses)
    differences = zigzag(lattice - (start + end - across))
    return {f"position_{axis}": planes(differences[:, i], 3) for i, axis in enumerate("xyz")}


def _colors(colors: IntArray, guesses: IntArray) -> dict[str, bytes]:
    """Green, and red and blue less green: neighbours differ in brightness more than in hue."""
    red, green, blue = colors.T
    channels = {"green": green, "red": red - green, "blue": blue - green}
    return {f"color_{name}": planes(_from_mean(channel, guesses), 2) for name, channel in channels.items()}


def _from_mean(values: IntArray, guesses: IntArray) -> IntArray:
    start, end, _ = _at(values, guesses)
    return zigzag(values - ((start + end) >> 1))


def _slots(slots: IntArray, guesses: IntArray) -> dict[str, bytes]:
    differs = slots != _at(slots, guesses)[1]
    return {
        "instance_differs": np.packbits(differs, bitorder="little").tobytes(),
        "instance": planes(slots[differs], 2),
    }


def _at(values: IntArray, guesses: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Values (V, ...) at the three guesses of each vertex; 0 before the first."""
    padded = np.concatenate([values, np.zeros_like(values[:1])])  # the row that -1 names
    if not len(values):
        return values, values, values
    return padded[guesses[:, 0]], padded[guesses[:, 1]], padded[guesses[:, 2]]
