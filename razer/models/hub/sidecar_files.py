"""Sidecar files of a model's weights: configuration and tokenizer beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from razer import files
from razer.errors import BadInput


def find_sidecar(weights: Path, name: str) -> Path | None:
    """The file of that name in the folder of the weights (or that is the weights), or else in the one above."""
    own = weights if weights.is_dir() else weights.parent
    return next((folder / name for folder in (own, own.parent) if (folder / name).is_file()), None)


def read_json(file: Path) -> dict[str, Any]:
    """The object that a JSON file holds; raises BadInput."""
    content = files.read_json(file)
    if not isinstance(content, dict):
        raise BadInput(f"{file} is not a JSON object")
    return content
