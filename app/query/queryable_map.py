"""Map of a finished run with the embedder that queries it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from app.console.streams import print_notes
from app.query.negative_prompt_cache import negative_prompts_of
from app.run_folder import run_folder as names
from app.settings.config_file import read_run_config
from app.settings.run_config import RunConfig
from razer.arrays import Float64Array
from razer.files import plain_os_errors
from razer.models import Embedder
from razer.panoptic_map import PanopticMap
from razer.plugins import NO_TRUST, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.saved_map import load_map


@dataclass(frozen=True)
class QueryableMap:
    """The map of a run in `folder`, with the text encoder of its embedder; up (3,): its upward direction."""

    folder: Path
    config: RunConfig
    embedder: Embedder
    panoptic: PanopticMap
    up: Float64Array


def open_queryable_map(
    folder: Path, embedder: str | None, assignments: tuple[str, ...], *, by_text: bool, trust: Trust = NO_TRUST
) -> QueryableMap:
    """Open a map and make the embedder that queries it.

    Args:
        folder: the folder of a finished run, or of a saved map.
        embedder: a name or module:Class; None: the one that the map was made with.
        assignments: texts section.key=value that change the map's settings, such as options of the embedder.
        by_text: whether queries are texts; the embedder then has to have a text encoder.
        trust: which outside code may be loaded besides what the command line names.

    Raises:
        BadInput: naming the file that is missing or damaged, or the embedder that cannot be used.
    """
    panoptic, config = open_map(folder, embedder, assignments, trust=trust)
    assert panoptic.text_queries is not None
    model = cast(Embedder, panoptic.text_queries.embedder)
    encoder = TextQueryEncoder(model, negative_prompts_of(panoptic.text_queries, config.embedder)) if by_text else None
    return QueryableMap(folder, config, model, replace(panoptic, text_queries=encoder), panoptic.up_or_z)


def open_map(
    folder: Path,
    embedder: str | None = None,
    assignments: tuple[str, ...] = (),
    *,
    trust: Trust = NO_TRUST,
    edited: bool = True,
) -> tuple[PanopticMap, RunConfig]:
    """A map with its settings, as people edited it or as it was made; its embedder, the settings' or the one named, is
    made when the first text comes. Arguments and errors as above."""
    with plain_os_errors(folder):
        config_file = path if (path := folder / names.CONFIG).is_file() else None
    # Another embedder does not take the options of the run's own.
    no_options = ("embedder.options={}",) if embedder else ()
    named = {"embedder.name": embedder}
    config = read_run_config(config_file, (*no_options, *assignments), named, trust=trust)
    panoptic = load_map(folder, embedder=config.embedder, edited=edited)
    print_notes(panoptic.edit_problems)
    return panoptic, config
