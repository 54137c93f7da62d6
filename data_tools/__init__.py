"""Where frames come from: readers, writers and synthetic worlds.

A lazy face (PEP 562): a name is imported when it is first asked for, so that `import data_tools` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from data_tools.registry import open_sequence
    from data_tools.writers.table import write_recording

__all__ = ["open_sequence", "write_recording"]

_MODULES = {"open_sequence": "data_tools.registry", "write_recording": "data_tools.writers.table"}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'data_tools' has no attribute '{name}'")
    value = globals()[name] = getattr(import_module(_MODULES[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
