"""The files of a saved map, by name. Imports nothing heavy, so that verbs can check folders before they load Open3D."""

from __future__ import annotations

from pathlib import Path

from razer.errors import BadInput

CONFIG = "config.toml"
EDITS = "edits.jsonl"
EMBEDDINGS = "embeddings.npz"
INSTANCES = "instances.json"
MESH_PLY = "mesh.ply"
PARTS = "parts.npz"
VOXELS = "map.npz"
FILES = {CONFIG, EDITS, EMBEDDINGS, INSTANCES, MESH_PLY, PARTS, VOXELS}


def is_map_folder(folder: Path) -> bool:
    """Whether a folder holds a saved map, be it the result of a run or of `PanopticMap.save`."""
    return (folder / INSTANCES).is_file() and (folder / MESH_PLY).is_file()


def require_map_folder(folder: Path) -> None:
    """Raise BadInput where a folder holds no saved map."""
    if not is_map_folder(folder):
        raise BadInput(f"{folder} is no run folder and no saved map (no {INSTANCES} or no {MESH_PLY})")
