"""Blocks of a growing map's mesh, sent as they change; viewer/src/decoding/blocks.ts reads them.

A packet (`app.page.packet`) of header {format, revision, epoch, blocks: [{key, vertices, triangles}]} and sections
`positions` (float32 x y z, metres), `colors` (uint8 r g b), `instances` (int32) and `triangles` (uint32, numbers within
the block), block after block; a block without triangles is not there any more.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.page.packet import pack
from razer.volume.mesh_extraction import LabelledMesh

FORMAT = 1
BLOCK_M = 1.28  # 64 voxels of 2 cm: a room is some dozens of them
_FAST = 1

BlockKey = tuple[int, int, int]


def mesh_blocks(mesh: LabelledMesh, block_m: float = BLOCK_M) -> dict[BlockKey, LabelledMesh]:
    """A mesh cut into cubes of edge `block_m` metres, by their place on the lattice: each triangle goes where its first
    corner lies, with copies of its vertices."""
    if not len(mesh.triangles):
        return {}
    cells = np.floor(mesh.vertices[mesh.triangles[:, 0]] / block_m).astype(np.int64)
    keys, owner = np.unique(cells, axis=0, return_inverse=True)
    owner = owner.reshape(-1)
    order = np.argsort(owner, kind="stable")
    ends = np.cumsum(np.bincount(owner, minlength=len(keys)))
    rows = np.split(order, ends[:-1])
    return {(int(x), int(y), int(z)): _cut_out(mesh, part) for (x, y, z), part in zip(keys, rows, strict=True)}


def _cut_out(mesh: LabelledMesh, rows: np.ndarray) -> LabelledMesh:
    vertices, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    triangles = corners.reshape(-1, 3).astype(np.int32)
    return LabelledMesh(mesh.vertices[vertices], mesh.colors[vertices], mesh.instances[vertices], triangles)


def encode_blocks(changed: Mapping[BlockKey, LabelledMesh | None], revision: int, epoch: int = 0) -> bytes:
    """The packet of the blocks that changed since a revision; None for those that are gone."""
    empty = LabelledMesh(np.zeros((0, 3), "f4"), np.zeros((0, 3), "u1"), np.zeros(0, "i4"), np.zeros((0, 3), "i4"))
    blocks = {key: empty if mesh is None else mesh for key, mesh in sorted(changed.items())}
    table = [
        {"key": list(key), "vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
        for key, mesh in blocks.items()
    ]
    parts = list(blocks.values()) or [empty]
    sections = {
        "positions": np.concatenate([mesh.vertices for mesh in parts]).astype("<f4").tobytes(),
        "colors": np.concatenate([mesh.colors for mesh in parts]).astype("u1").tobytes(),
        "instances": np.concatenate([mesh.instances for mesh in parts]).astype("<i4").tobytes(),
        "triangles": np.concatenate([mesh.triangles for mesh in parts]).astype("<u4").tobytes(),
    }
    header = {"format": FORMAT, "revision": revision, "epoch": epoch, "blocks": table}
    return pack(header, sections, level=_FAST)
