"""Changed blocks of a growing mesh in one packet, read again by app/page/viewer/src/decoding/blocks.ts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from app.page.packet import pack
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk

FORMAT = 1
_FAST = 1  # of gzip's levels: it is made again every few seconds


def encode_blocks(blocks: Mapping[Chunk, LabelledMesh], revision: int, epoch: int) -> bytes:
    """Blocks, of which an empty one is to vanish, as plain arrays one after the other; triangles by the vertices of
    their own block."""
    meshes = list(blocks.values())
    table = [
        {"key": list(key), "vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
        for key, mesh in blocks.items()
    ]
    sections = {
        "positions": _joined([mesh.vertices for mesh in meshes], "<f4"),
        "colors": _joined([mesh.colors for mesh in meshes], "u1"),
        "instances": _joined([mesh.instances for mesh in meshes], "<i4"),
        "triangles": _joined([mesh.triangles for mesh in meshes], "<u4"),
    }
    return pack({"format": FORMAT, "revision": revision, "epoch": epoch, "blocks": table}, sections, _FAST)


def _joined(parts: Sequence[NDArray], kind: str) -> bytes:
    return b"".join(np.ascontiguousarray(part, kind).tobytes() for part in parts)
