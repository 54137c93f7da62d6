"""Settings as TOML text; the standard library reads TOML but does not write it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from razer.storage.settings_list import Setting


def toml_text(settings: list[Setting], header: str = "") -> str:
    """TOML with the meaning above each setting; `header` becomes the first comment.

    A setting without a value is shown as a comment, since TOML has no null.
    """
    lines = [f"# {line}" for line in header.splitlines()]
    section = ""
    for setting in settings:
        if setting.section != section:
            section = setting.section
            lines += ["", f"[{section}]"]
        bounds = f" ({setting.allowed})" if setting.allowed else ""
        lines += ["", f"# {setting.meaning}{bounds}", _assignment(setting.key, setting.value)]
    return "\n".join(lines).strip() + "\n"


def _assignment(key: str, value: Any) -> str:
    return f"# {key} =" if value is None else f"{key} = {toml_value(value)}"


def toml_value(value: Any) -> str:
    """One value on one line: strings, booleans, numbers, and lists and tables of them."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        # A JSON string is a TOML basic string, once DEL, which TOML wants escaped, is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        inner = ", ".join(f"{toml_value(str(k))} = {toml_value(v)}" for k, v in value.items() if v is not None)
        return f"{{ {inner} }}" if inner else "{}"
    return f"[{', '.join(toml_value(item) for item in value)}]"
