"""Writing a saved map: all of its files, or none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from razer.arrays import Float64Array, Int32Array
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.storage.atomic_files import replace_files
from razer.storage.embeddings_npz import write_embeddings_npz
from razer.storage.file_names import CONFIG, EDITS, EMBEDDINGS, FILES, INSTANCES, MESH_PLY, PARTS, VOXELS
from razer.storage.instances_json import write_instances_json
from razer.storage.parts_npz import write_parts_npz
from razer.storage.ply import write_mesh_ply

if TYPE_CHECKING:  # it brings Open3D and torch along
    from razer.volume.voxel_map import VoxelMap


@dataclass(frozen=True)
class SavedParts:
    """What is saved of a map: its instances and mesh, the upward direction (3,), the seconds of frames by index, the
    text of config.toml, and the volume; where it has parts, these and the part (V,) of each vertex."""

    objects: Sequence[MapObject]
    mesh: LabelledMesh
    up: Float64Array | None
    stamps: Mapping[int, float]
    config_text: str
    volume: VoxelMap | None
    parts: Sequence[MapObject] = ()
    vertex_parts: Int32Array | None = None


def save_map(folder: Path, parts: SavedParts) -> None:
    """Write a map into a folder, which is made if need be; none of the files takes its place before all are complete.
    An older map is replaced; a run is not, as its trajectory and timeline are of another map.

    Raises:
        BadInput: if the folder holds something else, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or {path.name for path in folder.iterdir()} - FILES):
        raise BadInput(f"{folder} is there and holds something else than a saved map: choose another folder")
    writers = {
        MESH_PLY: lambda path: write_mesh_ply(path, parts.mesh),
        EMBEDDINGS: lambda path: write_embeddings_npz(path, [*parts.objects, *parts.parts]),
        CONFIG: lambda path: path.write_text(parts.config_text, encoding="utf-8"),
        INSTANCES: lambda path: write_instances_json(path, parts.objects, parts.up, parts.stamps, parts.parts),
    }
    if parts.parts and (vertex_parts := parts.vertex_parts) is not None:
        writers[PARTS] = lambda path: write_parts_npz(path, vertex_parts)
    if (volume := parts.volume) is not None:
        from razer.storage.volume_npz import save_voxels  # late: it brings Open3D and torch along

        writers[VOXELS] = lambda path: save_voxels(path, volume)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        replace_files({folder / name: writer for name, writer in writers.items()})
        for name in {EDITS, PARTS, VOXELS} - writers.keys():
            (folder / name).unlink(missing_ok=True)  # that of an older map; what is saved has its edits in it
    except OSError as error:
        raise BadInput(f"{folder} cannot be written ({error.strerror}): choose another folder") from error
