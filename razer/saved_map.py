"""Opening a saved map: what a run or `PanopticMap.save` left becomes a map again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float32Array, Float64Array, Int32Array
from razer.edits.apply import apply_edits
from razer.edits.log import EditLog
from razer.errors import BadInput, one_line
from razer.files import MALFORMED, parse_toml, plain_os_errors, read_text
from razer.map_object import MapObject
from razer.models import Embedder, embedder_of, make_embedder
from razer.panoptic_map import PanopticMap
from razer.plugins import FULL_TRUST, NO_TRUST, EmbedderSettings, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.storage.embeddings_npz import read_embeddings_npz
from razer.storage.file_names import CONFIG, EMBEDDINGS, INSTANCES, MESH_PLY, PARTS, VOXELS, require_map_folder
from razer.storage.instances_json import read_instances_json, read_parts_json
from razer.storage.parts_npz import read_parts_npz
from razer.storage.ply import read_mesh_ply

Bank = tuple[Float32Array, Float64Array]


def load_map(
    folder: str | Path,
    *,
    embedder: str | Embedder | EmbedderSettings | None = None,
    embedder_options: Mapping[str, Any] | None = None,
    trust_plugins: bool = False,
    device: str = "CPU:0",
    edited: bool = True,
) -> PanopticMap:
    """Open a map that a run or `PanopticMap.save` left, as people edited it by hand; the volume and the embedder are
    loaded when they are needed.

    Args:
        folder: of a run, or that `save` wrote.
        embedder: what texts are embedded by, an object, its settings, or a name with `embedder_options`; None = the
            one that the map was made with.
        embedder_options: its named arguments.
        trust_plugins: whether an embedder from outside the project, "module:Class", may be loaded because the
            folder's settings name it.
        device: where the volume is put, such as "CUDA:0".
        edited: whether the hand edits of the folder's log are applied.

    Raises:
        BadInput: naming what is missing or damaged.
    """
    folder = Path(folder)
    with plain_os_errors(folder):
        require_map_folder(folder)
    trust = FULL_TRUST if trust_plugins else NO_TRUST
    encoder = TextQueryEncoder.deferred(partial(_embedder, folder, embedder, embedder_options or {}, trust))
    panoptic = replace(_as_saved(folder), text_queries=encoder, open_volume=partial(_open_volume, folder, device))
    return apply_edits(panoptic, EditLog.read(folder)) if edited else panoptic


def _as_saved(folder: Path) -> PanopticMap:
    """The map that the files of a folder hold, without its volume and what encodes texts; raises BadInput."""
    mesh = read_mesh_ply(folder / MESH_PLY)
    try:
        objects, up = read_instances_json(folder / INSTANCES)
        banks = read_embeddings_npz(folder / EMBEDDINGS)
        parts = read_parts_json(folder / INSTANCES)
        vertex_parts = read_parts_npz(folder / PARTS, len(mesh.vertices)) if parts else None
    except MALFORMED as error:
        why = one_line(error) if isinstance(error, BadInput) else "its content is of another form"
        problem = f"{INSTANCES}, {EMBEDDINGS} or {PARTS} is missing or damaged ({why})"
        raise BadInput(f"{folder}: {problem}; run again") from error
    known = np.isin(mesh.instances, [item.id for item in objects])
    return PanopticMap(
        _completed(objects, mesh.instances, banks),
        replace(mesh, instances=np.where(known, mesh.instances, 0).astype(np.int32)),
        up=up,
        config_text=_config_text(folder),
        parts=parts if vertex_parts is None else _completed(parts, vertex_parts, banks),
        vertex_parts=vertex_parts,
        folder=folder,
    )


def _completed(objects: Sequence[MapObject], labels: Int32Array, banks: Mapping[int, Bank]) -> tuple[MapObject, ...]:
    """Objects with the number of vertices that bear their id (V,), and with their embeddings."""
    n_vertices = Counter(labels.tolist())
    nothing = (np.zeros((0, 0), np.float32), np.zeros(0))
    completed = []
    for item in objects:
        embeddings, weights = banks.get(item.id, nothing)
        completed.append(replace(item, n_vertices=n_vertices[item.id], embeddings=embeddings, weights=weights))
    return tuple(completed)


def _embedder(
    folder: Path, chosen: str | Embedder | EmbedderSettings | None, options: Mapping[str, Any], trust: Trust
) -> Embedder:
    if chosen is None:
        return embedder_of(_saved_embedder(folder).with_trust(trust))
    if isinstance(chosen, EmbedderSettings):
        return embedder_of(chosen)
    return make_embedder(chosen, options, trust) if isinstance(chosen, str) else chosen


def _saved_embedder(folder: Path) -> EmbedderSettings:
    """The embedder that a map was made with, `appearance` where nothing says; raises BadInput."""
    try:
        section = parse_toml(_config_text(folder), str(folder / CONFIG)).get("embedder", {})
        return EmbedderSettings.model_validate({"name": "appearance", **section})
    except MALFORMED as error:
        raise BadInput(f"{folder / CONFIG} is damaged ({one_line(error)}): name the embedder yourself") from error


def _config_text(folder: Path) -> str:
    path = folder / CONFIG
    return read_text(path) if path.is_file() else ""


def _open_volume(folder: Path, device: str) -> Any:
    if not (folder / VOXELS).is_file():
        raise BadInput(f"{folder} has no {VOXELS}: its volume was not saved")
    from razer.storage.volume_npz import load_voxels  # late: it brings Open3D and torch along

    return load_voxels(folder / VOXELS, device)
