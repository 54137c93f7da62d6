"""Adding the map of a run to a library."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from app.library.tables.instance_library import InstanceLibrary
from app.library.tables.instance_rows import Entry, rows_of
from app.library.tables.model_identity import ModelIdentity
from app.library.thumbnails import forget_thumbnails, keep_thumbnails, thumbnails_of
from app.query.queryable_map import open_map
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap
from razer.storage.file_names import require_map_folder

FORMAT = 1


@dataclass(frozen=True)
class Added:
    """What was added: run, scene, how many instances, into which table."""

    run: str
    scene: str
    n_instances: int
    table: str


def add_runs(
    folders: Iterable[Path], uri: str, scene: str | None = None, *, with_thumbnails: bool = True
) -> Iterator[Added]:
    """Add the maps of several runs as `add_run` does, each once. Raises BadInput, before any is added where one of the
    folders holds no map."""
    chosen = {run_name(folder): folder for folder in folders}
    for folder in chosen.values():
        require_map_folder(_chosen(folder))
    for folder in chosen.values():
        yield add_run(folder, uri, scene, with_thumbnails=with_thumbnails)


def add_run(folder: Path, uri: str, scene: str | None = None, *, with_thumbnails: bool = True) -> Added:
    """Add the map of a run, as people edited it, in the place of what the library has of it.

    Args:
        folder: of a finished run, or of a saved map.
        uri: of the library, which is made if it is not there.
        scene: what the place is called; None: as the recording, or else the run.
        with_thumbnails: whether pictures of the best views are kept, too.

    Raises:
        BadInput: where the run cannot be read, has no embeddings, or the library cannot be written to.
    """
    folder = _chosen(folder)
    panoptic, config = open_map(folder)
    model = _model_of(folder, panoptic, config)
    entry = _entry(folder, panoptic, config, scene or _scene_of(folder, config))
    rows = rows_of(panoptic, entry, model)
    table = InstanceLibrary.made(uri, model)
    pictures = thumbnails_of(folder, panoptic, config.input) if with_thumbnails else {}
    keep_thumbnails(uri, entry.run, entry.generation, pictures)
    table.add(rows, entry.generation)
    forget_thumbnails(uri, entry.run, before=entry.generation)
    return Added(entry.run, entry.scene, len(set(rows["id"].to_pylist())), model.table)


def run_name(folder: Path) -> str:
    """What a library calls a run: its full path."""
    return str(_chosen(folder).absolute().resolve())


def _chosen(folder: Path) -> Path:
    """The run with given poses where a folder holds a pair."""
    from app.page.other_poses import chosen_run  # late: it brings what draws pages along

    return chosen_run(folder)


def _model_of(folder: Path, panoptic: PanopticMap, config: RunConfig) -> ModelIdentity:
    widths = {item.embeddings.shape[1] for item in (*panoptic.objects, *panoptic.parts) if len(item.embeddings)}
    if len(widths) != 1:
        raise BadInput(f"{folder} has no embeddings: there is nothing to search it by")
    return ModelIdentity.of(config.embedder, widths.pop())


def _scene_of(folder: Path, config: RunConfig) -> str:
    recording = config.input.folder
    return Path(recording).name if recording else folder.absolute().name


def _entry(folder: Path, panoptic: PanopticMap, config: RunConfig, scene: str) -> Entry:
    now = time.time_ns()
    facts = {
        "format": FORMAT,
        "added": datetime.fromtimestamp(now / 1e9, UTC).isoformat(timespec="seconds"),
        "razer": metadata.version("razer"),
        "recording": config.input.folder,
        "segmenter": config.segmenter.name,
        "embedder": config.embedder.name,
        "instances": len(panoptic.objects) + len(panoptic.parts),
        "epoch": panoptic.epoch,
        "up": None if panoptic.up is None else panoptic.up.tolist(),
    }
    return Entry(run_name(folder), scene, now, json.dumps(facts))
