"""Which model made the vectors of a map: embeddings of different models lie in tables of their own."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from razer.errors import BadInput
from razer.models.hub.checksum import checksum
from razer.models.hub.model_file import model_file
from razer.plugins import EmbedderSettings

METADATA = b"razer.model"
_DIGITS = 12


@dataclass(frozen=True)
class ModelIdentity:
    """An embedder by name and options, the width D of its vectors, and its version: what its files hold, as far as they
    are here."""

    name: str
    options: Mapping[str, Any]
    dimension: int
    version: str

    @classmethod
    def of(cls, settings: EmbedderSettings, dimension: int) -> ModelIdentity:
        """That of an embedder whose vectors have `dimension` numbers."""
        contents = _contents(settings.options)
        version = hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()[:_DIGITS]
        return cls(settings.name, settings.options, dimension, version)

    @property
    def table(self) -> str:
        """The name of the table of its vectors. Where a model's files lie is not part of it, what they hold is."""
        plain = re.sub(r"[^a-z0-9]+", "_", self.name.lower()).strip("_") or "model"
        return f"{plain[-24:].strip('_')}-{self.dimension}-{self.version}"

    @property
    def settings(self) -> EmbedderSettings:
        """What makes the embedder; nothing from outside is trusted."""
        return EmbedderSettings(name=self.name, options=dict(self.options))

    def to_bytes(self) -> bytes:
        """As the metadata of a table."""
        known = {name: getattr(self, name) for name in ("name", "options", "dimension", "version")}
        return json.dumps(known, default=str).encode()

    @classmethod
    def from_bytes(cls, content: bytes) -> ModelIdentity:
        """From the metadata of a table; raises ValueError, KeyError or TypeError."""
        known = json.loads(content)
        return cls(str(known["name"]), dict(known["options"]), int(known["dimension"]), str(known["version"]))


def _contents(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options with checksums of the files that they name in place of their paths."""
    return {name: _content(value) for name, value in options.items()}


def _content(value: Any) -> Any:
    if isinstance(value, Mapping):
        return _contents(value)
    if isinstance(value, str | Path):
        with suppress(BadInput, OSError):
            place = model_file(value)
            files = sorted(f for f in place.rglob("*") if f.is_file()) if place.is_dir() else [place]
            return [checksum(file, "sha256") for file in files]
    return value if isinstance(value, str | int | float | bool | None) else str(value)
