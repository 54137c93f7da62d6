"""Where settings come from: defaults, then a TOML file, then --set, then the options of a verb."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.plugins import NO_TRUST, Trust
from razer.storage.settings_list import list_settings

# What settings were called before, so that a message can name the new one and older run folders can be read.
RENAMED = {
    "follow.enabled": "reintegration.enabled",
    "follow.every": "reintegration.frames_per_keyframe",
    "follow.draft": "reintegration.keyframe_stride",
    "follow.live_replays": "reintegration.replays_per_frame",
    "follow.pace": "reintegration.max_replays_per_frame",
    "follow.live_shift_voxels": "reintegration.min_shift_voxels",
    "follow.final_shift_voxels": "reintegration.min_final_shift_voxels",
    "follow.fuse_shared_votes": "reintegration.fuse_shared_votes",
    "follow.memory_mb": "reintegration.memory_mb",
    "maintenance.every": "maintenance.interval_frames",
    "association.association": "association.geometry_distance",
    "lifting.see_through_gap_m": "lifting.background_gap_m",
}


def read_config(
    file: Path | None, assignments: Iterable[str], flags: Mapping[str, Any], *, trust: Trust = NO_TRUST
) -> RunConfig:
    """The settings of a run.

    Args:
        file: a TOML file; its plug-ins are data's choice.
        assignments: texts section.key=value, from the command line.
        flags: dotted names with values, None = not given, from the command line.
        trust: which outside code may be loaded besides what the command line names.

    Raises:
        BadInput: naming the setting and the nearest valid one, if any is wrong.
    """
    tree = _read_toml(file) if file else {}
    named = []
    for assignment in assignments:
        name, separator, text = assignment.partition("=")
        if not separator or not name.strip():
            raise BadInput(f"--set {assignment}: write it as section.key=value")
        value = _parse(text.strip())
        named += _texts(value)
        _assign(tree, name.strip(), value)
    for name, value in flags.items():
        if value is not None:
            named += _texts(value)
            _assign(tree, name, value)
    try:
        config = RunConfig.model_validate(tree)
    except ValidationError as error:
        raise BadInput(_plain_line(error, file)) from None
    trusted = trust.also(named)
    sections = {name: getattr(config, name).trusting(trusted) for name in ("input", "segmenter", "embedder")}
    return config.model_copy(update=sections)


def _read_toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{file}: cannot be read ({error.strerror}); give an existing TOML file") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{file}: not TOML: {error}") from error


def _parse(text: str) -> Any:
    """A value as TOML reads it; what is no TOML value is a string, so that quotes are optional."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _texts(value: Any) -> list[str]:
    """All texts in a value."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list):
        return [text for part in value for text in _texts(part)]
    return [value] if isinstance(value, str) else []


def _assign(tree: dict[str, Any], name: str, value: Any) -> None:
    *sections, key = name.split(".")
    for section in sections:
        tree = tree.setdefault(section, {})
        if not isinstance(tree, dict):
            raise BadInput(f"setting {name}: {section} is a single value, not a section")
    tree[key] = value


def _plain_line(error: ValidationError, file: Path | None) -> str:
    first = error.errors()[0]
    name = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        name = _down_to_leaf(name, first["input"])
        if name in RENAMED:
            return f"setting {name} is called {RENAMED[name]} now"
        return f"unknown setting {name}{_nearest(name)}; `razer config` lists all settings"
    where = f" (from {file}, --set or an option)" if file else ""
    return f"setting {name} = {first['input']!r}{where}: {first['msg'].removeprefix('Input ')}"


def _down_to_leaf(name: str, value: Any) -> str:
    while isinstance(value, Mapping) and value:
        key, value = next(iter(value.items()))
        name = f"{name}.{key}"
    return name


def _nearest(name: str) -> str:
    names = {setting.name for setting in list_settings(RunConfig())} | set(RunConfig.model_fields)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.4)
    return f"; did you mean {close[0]}?" if close else ""
