"""Disk cache of negative prompts: the names that queries are scored against, embedded once for each text encoder."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from app.console.streams import progress_console
from razer.errors import BadInput
from razer.files import read_npz
from razer.models.hub.model_file import model_file
from razer.plugins import EmbedderSettings
from razer.query.ranking import NegativePrompts
from razer.query.text_queries import TEMPLATES, TextQueryEncoder
from razer.storage.atomic_files import replace_file

FORMAT = 1


def negative_prompts_of(encoder: TextQueryEncoder, settings: EmbedderSettings) -> NegativePrompts:
    """The negative prompts of an embedder, cached by its settings; raises BadInput if it has no text encoder."""
    if encoder.is_table:
        return encoder.negatives
    names, path = encoder.negative_names, _folder() / f"contrast-{_key(encoder, settings)}.npz"
    with suppress(BadInput):
        return NegativePrompts(names, read_npz(path, ["vectors"])["vectors"])
    progress_console().print(f"embedding {len(names)} negative prompts; cached in {path.parent}", soft_wrap=True)
    prompts = encoder.negatives
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda part: np.savez_compressed(part, format=FORMAT, vectors=prompts.vectors))
    return prompts


def _folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "razer"


def _key(encoder: TextQueryEncoder, settings: EmbedderSettings) -> str:
    """What the vectors follow from: names, prompts, and the embedder with its files as they are."""
    content = [FORMAT, encoder.negative_names, TEMPLATES, settings.name, settings.options, _files(settings.options)]
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:24]


def _files(options: Mapping[str, Any]) -> list[tuple[str, int, int]]:
    """Place, size and time of the files that options name, by path, hub id or name of the catalogue, and of those in
    folders."""
    stats = []
    for value in options.values():
        if isinstance(value, Mapping):
            stats += _files(value)
        elif isinstance(value, str):
            with suppress(BadInput, OSError):
                place = model_file(value)
                files = sorted(place.rglob("*")) if place.is_dir() else [place]
                stats += [(str(f.absolute()), f.stat().st_size, f.stat().st_mtime_ns) for f in files if f.is_file()]
    return stats
