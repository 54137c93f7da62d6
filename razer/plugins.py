"""Parts chosen by name: a table of the ones that ship, and any outside `module:Class`."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from razer.frame import BadInput


def load(kind: str, name: str, table: Mapping[str, str], options: Mapping[str, Any]) -> Any:
    """Build the part called `name` from `table` (name -> "module:Class"), or from `name` itself if it is
    "module:Class". Raises BadInput for an unknown name or for options the class does not take."""
    target = table.get(name, name)
    module_name, separator, class_name = target.partition(":")
    if not separator:
        raise BadInput(f"unknown {kind} '{name}': choose one of {', '.join(sorted(table))}, or module:Class")
    try:
        part = getattr(importlib.import_module(module_name), class_name)
    except (ImportError, AttributeError) as error:
        raise BadInput(f"{kind} '{name}' cannot be loaded: {error}") from error
    try:
        return part(**options)
    except TypeError as error:
        raise BadInput(f"{kind} '{name}' does not take these options: {error}") from error
