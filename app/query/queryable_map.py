"""A finished run and the embedder by which it can be asked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from app.query.contrast_cache import contrast_of
from app.run_folder import run_folder as names
from app.settings.config_file import read_config
from app.settings.run_config import RunConfig
from razer.arrays import Float64Array
from razer.models import Embedder, make_embedder
from razer.panoptic_map import PanopticMap
from razer.plugins import NO_TRUST, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.saved_map import load_map


@dataclass(frozen=True)
class QueryableMap:
    """The map of a run in `folder`, with the words of its embedder; up (3,), its upward direction."""

    folder: Path
    config: RunConfig
    embedder: Embedder
    panoptic: PanopticMap
    up: Float64Array


def open_queryable_map(
    folder: Path, embedder: str | None, assignments: tuple[str, ...], *, by_text: bool, trust: Trust = NO_TRUST
) -> QueryableMap:
    """Read a run; its own embedder unless another one is named. Raises BadInput."""
    panoptic = load_map(folder)
    noted = folder / names.CONFIG
    # Another embedder does not take the options of the run's own.
    anew = ("embedder.options={}",) if embedder else ()
    named = {"embedder.name": embedder}
    config = read_config(noted if noted.is_file() else None, (*anew, *assignments), named, trust=trust)
    made = make_embedder(config.embedder.name, config.embedder.options, config.embedder.trust)
    words = TextQueryEncoder(made, contrast_of(TextQueryEncoder(made), config.embedder)) if by_text else None
    return QueryableMap(folder, config, made, replace(panoptic, words=words), panoptic.up_or_z)
