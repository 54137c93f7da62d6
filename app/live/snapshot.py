"""What a run tells the process that serves it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from razer.arrays import Float64Array
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk


@dataclass(frozen=True)
class Snapshot:
    """The map after a frame: all instances; the chunks that are told anew, the rest as before; what became of ids since
    the last snapshot, 0 = nobody; the upward direction (3,) as cameras are held."""

    frame: int
    objects: tuple[MapObject, ...]
    chunks: Mapping[Chunk, LabelledMesh]
    renamed: Mapping[int, int] = field(default_factory=dict)
    up: Float64Array | None = None
    is_rebuilt: bool = False


@dataclass(frozen=True)
class Finished:
    """The run is over, and its map lies in a folder."""

    folder: Path
