"""Class names of a semantic model: from a file, from its metadata, or from the configuration beside it."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from razer.errors import BadInput
from razer.files import MALFORMED, parse_json, read_text
from razer.models.hub.sidecar_files import find_sidecar, read_json

KEYS = ("names", "classes", "class_names", "labels", "id2label", "categories")
_MOST_CLASSES = 100_000


def names_of(weights: Path, metadata: Mapping[str, str], file: str | Path | None) -> tuple[str, ...]:
    """The name of each class by its number, '' for numbers that have none; of synonyms the first.

    Args:
        weights: the model.
        metadata: what its file says about itself; one of KEYS, in any case, holds the names.
        file: names that replace those: a list or an object in JSON, or one name a line, numbered from 0.

    Raises:
        BadInput: where there are none, or none that can be read.
    """
    if file is not None:
        return parsed_names(read_text(Path(file).expanduser()), str(file))
    by_key = {key.lower(): text for key, text in metadata.items()}
    key = next((key for key in KEYS if by_key.get(key, "").strip()), None)
    if key is not None:
        return parsed_names(by_key[key], f"{weights}: its metadata '{key}'")
    config = find_sidecar(weights, "config.json")
    if config is not None and (listed := read_json(config).get("id2label")):
        return numbered_names(listed, str(config))
    raise BadInput(
        f"{weights} does not say what its classes are called, by metadata {', '.join(KEYS[:3])} ... or a config.json "
        "beside it: set segmenter option names to a file with one name a line, the first for class 0"
    )


def parsed_names(text: str, source: str) -> tuple[str, ...]:
    """Names written in JSON, as a Python literal, or one a line or with commas; raises BadInput naming the source."""
    for parse in (partial(parse_json, name=source), ast.literal_eval):
        try:
            value = parse(text)
        except (ValueError, SyntaxError, RecursionError, MemoryError):
            continue
        return numbered_names(value, source)
    if text.lstrip()[:1] in ("{", "["):
        raise BadInput(f"{source} cannot be read: {text.strip()[:40]!r}")
    lines = text.strip().splitlines()
    return numbered_names(lines[0].split(",") if len(lines) == 1 else lines, source)


def numbered_names(value: Any, source: str) -> tuple[str, ...]:
    """Names of a list in the order of the classes, of an object {number: name} or {name: number}, or of a list of
    objects with id and name; raises BadInput naming the source."""
    try:
        names = _by_number(value)
    except MALFORMED:
        names = {}
    if not names or not all(0 <= number < _MOST_CLASSES for number in names):
        raise BadInput(
            f"{source} should name the classes by number, as in {{0: 'wall', 1: 'floor'}} or a list of names"
        )
    return tuple(_first_synonym(names.get(number, "")) for number in range(max(names) + 1))


def _by_number(value: Any) -> dict[int, str]:
    if isinstance(value, Mapping):
        pairs = list(value.items())
        if all(isinstance(number, int) for _, number in pairs):
            pairs = [(number, name) for name, number in pairs]
        return {int(number): _text(name) for number, name in pairs}
    if isinstance(value, Sequence) and not isinstance(value, str):
        if all(isinstance(entry, Mapping) for entry in value):
            return {int(entry["id"]): _text(entry["name"]) for entry in value}
        return {number: _text(name) for number, name in enumerate(value)}
    raise TypeError


def _text(name: Any) -> str:
    if not isinstance(name, str):
        raise TypeError
    return name.strip()


def _first_synonym(name: str) -> str:
    """ADE20K lists synonyms: "floor;flooring", "door, double door"."""
    return name.replace(";", ",").split(",")[0].strip()
