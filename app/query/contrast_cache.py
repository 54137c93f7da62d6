"""The names that queries are set against, embedded once for each text encoder and kept in the user's cache."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from app.console.streams import progress_console
from razer.errors import BadInput
from razer.models.hub.model_file import model_file
from razer.plugins import EmbedderSettings
from razer.query.ranking import NegativePrompts
from razer.query.text_queries import TEMPLATES, TextQueryEncoder

FORMAT = 1


def contrast_of(words: TextQueryEncoder, settings: EmbedderSettings) -> NegativePrompts:
    """The contrast of an embedder made by these settings; raises BadInput if it has no text side."""
    if words.is_table:
        return words.contrast
    names, path = words.contrast_names, _folder() / f"contrast-{_key(words, settings)}.npz"
    with (
        suppress(OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile),
        np.load(path, allow_pickle=False) as kept,
    ):
        return NegativePrompts(names, kept["vectors"])
    progress_console().print(f"embedding {len(names)} names to compare with; kept in {path.parent}", soft_wrap=True)
    contrast = words.contrast
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f".part-{os.getpid()}-{path.name}")
        np.savez_compressed(part, format=FORMAT, vectors=contrast.vectors)
        os.replace(part, path)
    return contrast


def _folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "razer"


def _key(words: TextQueryEncoder, settings: EmbedderSettings) -> str:
    """What the vectors follow from: names, prompts, and the embedder with its files as they are."""
    told = [FORMAT, words.contrast_names, TEMPLATES, settings.name, settings.options, _files(settings.options)]
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()[:24]


def _files(options: Mapping[str, Any]) -> list[tuple[str, int, int]]:
    """Place, size and time of the files that options name, by path, hub id or name of the catalogue, and of those in
    folders."""
    found = []
    for value in options.values():
        if isinstance(value, Mapping):
            found += _files(value)
        elif isinstance(value, str):
            with suppress(BadInput, OSError):
                place = model_file(value)
                files = sorted(place.rglob("*")) if place.is_dir() else [place]
                found += [(str(f.absolute()), f.stat().st_size, f.stat().st_mtime_ns) for f in files if f.is_file()]
    return found
