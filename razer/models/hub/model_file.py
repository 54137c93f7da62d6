"""Resolution of the option `weights` to a file or folder: path, catalogue name or hub id."""

from __future__ import annotations

import re
from pathlib import Path

from razer.errors import BadInput
from razer.models.hub.cached_content import require_published
from razer.models.hub.catalogue import catalogue

_HUB_ID = re.compile(r"[\w.-]+/[\w.-]+")


def model_file(name_or_path: str | Path) -> Path:
    """The file or folder of a model: a path that exists as it stands, a name of the catalogue, or a hub id such as
    "openai/clip-vit-base-patch32"; the latter two only when they are in the Hugging Face cache.

    A model of one file gives that file, one of several the folder that holds them as the hub names them. What lies in
    the cache is held against its published checksums. Raises BadInput with the command that fetches what is missing or
    damaged, and what works without it.
    """
    path, name = Path(name_or_path).expanduser(), str(name_or_path)
    if path.exists():
        require_published(path)
        return path
    entry = catalogue().get(name)
    if entry is None and not _HUB_ID.fullmatch(name):
        raise BadInput(f"no model file {path}, and no such name in the catalogue: 'razer models list' shows the names")

    # Late: it takes a moment, and a path needs none of it.
    from razer.models.hub.cache import cached_model, cached_snapshot

    cached = cached_model(entry) if entry else cached_snapshot(name)
    if cached is not None:
        require_published(cached, entry)
        return cached
    if entry is not None:
        raise BadInput(f"model '{name}' is not downloaded: {entry.how_to_get}")
    raise BadInput(f"no file or folder {path}, and not in the Hugging Face cache: run 'hf download {name}'")
