"""Layered settings: defaults, a preset, a TOML file, --set, then the options of a verb; later ones win."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from app.settings.assignments import parse_value, split_assignment
from app.settings.presets import preset_settings
from app.settings.renamed_settings import REMOVED, RENAMED, with_new_names
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.files import read_toml
from razer.plugins import NO_TRUST, Trust
from razer.settings import problem_of
from razer.storage.settings_list import list_settings

# What mapped runs and saved maps that do not say it: "auto" is for those to come.
_WITHOUT_NAMES = {"segmenter": "geometric", "embedder": "appearance"}


def read_config(
    file: Path | None,
    assignments: Iterable[str],
    flags: Mapping[str, Any],
    *,
    trust: Trust = NO_TRUST,
    preset: str | None = None,
) -> RunConfig:
    """The settings of a run.

    Args:
        file: a TOML file that the user names; its plug-ins are data's choice.
        assignments: texts section.key=value, from the command line.
        flags: dotted names with values, None = not given, from the command line.
        trust: which outside code may be loaded besides what the command line names.
        preset: a named set of settings, which all others override.

    Raises:
        BadInput: naming the preset, or the setting and the nearest valid one, if any is wrong; a former name with
            today's.
    """
    tree: dict[str, Any] = {}
    for name, value in preset_settings(preset).items():
        _assign(tree, name, value)
    if file:
        _override(tree, read_toml(file))
    for section in ("segmenter", "embedder"):  # what an earlier run was asked for says nothing about this one
        if isinstance(keys := tree.get(section), dict):
            keys.pop("asked", None)
    return _validated(tree, file, assignments, flags, trust)


def read_run_config(
    file: Path | None,
    assignments: Iterable[str] = (),
    flags: Mapping[str, Any] = MappingProxyType({}),
    *,
    trust: Trust = NO_TRUST,
) -> RunConfig:
    """The settings that a run folder keeps; an older run's may bear former names, which are translated.

    Args:
        file: the config.toml of a run; its plug-ins are data's choice.
        assignments: texts section.key=value, from the command line.
        flags: dotted names with values, None = not given, from the command line.
        trust: which outside code may be loaded besides what the command line names.

    Raises:
        BadInput: naming the setting, if any is wrong.
    """
    tree = with_new_names(read_toml(file)) if file else {}
    for section, name in _WITHOUT_NAMES.items():
        if isinstance(keys := tree.setdefault(section, {}), dict):
            keys.setdefault("name", name)
    return _validated(tree, file, assignments, flags, trust)


def _validated(
    tree: dict[str, Any], file: Path | None, assignments: Iterable[str], flags: Mapping[str, Any], trust: Trust
) -> RunConfig:
    """The settings of a file's content (changed in place), those of the command line over them."""
    named: list[str] = []  # on the command line, which may name plug-ins
    for assignment in assignments:
        name, text = split_assignment(assignment, "it as section.key=value")
        value = parse_value(text)
        named += _texts(value)
        _assign(tree, name, value)
    for name, value in flags.items():
        if value is not None:
            named += _texts(value)
            _assign(tree, name, value)
    try:
        config = RunConfig.model_validate(tree)
    except ValidationError as error:
        raise BadInput(_plain_line(error, file)) from None
    trusted = trust.also(named)
    sections = {name: getattr(config, name).with_trust(trusted) for name in ("input", "segmenter", "embedder")}
    return config.model_copy(update=sections)


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


def _override(tree: dict[str, Any], other: Mapping[str, Any]) -> None:
    """Replace what another tree names, keys within sections one by one."""
    for key, value in other.items():
        if isinstance(value, dict) and isinstance(tree.get(key), dict):
            tree[key] |= value
        else:
            tree[key] = value


def _plain_line(error: ValidationError, file: Path | None) -> str:
    first = error.errors()[0]
    name = ".".join(str(part) for part in first["loc"])
    where = f" (from {file}, --set or an option)" if file else ""
    if first["type"] == "extra_forbidden":
        name = _down_to_leaf(name, first["input"])
        if name in RENAMED:
            return f"setting {name} is called {RENAMED[name]} now"
        if name in REMOVED:
            return f"setting {name} is gone: {REMOVED[name]}"
        return f"unknown setting {name}{where}{_nearest(name)}; `razer config` lists all settings"
    given = "" if isinstance(first["input"], dict) else f" = {first['input']!r}"
    return f"setting {name}{given}{where}: {problem_of(error)}"


def _down_to_leaf(name: str, value: Any) -> str:
    while isinstance(value, Mapping) and value:
        key, value = next(iter(value.items()))
        name = f"{name}.{key}"
    return name


def _nearest(name: str) -> str:
    names = {setting.name for setting in list_settings(RunConfig())} | set(RunConfig.model_fields)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.4)
    return f"; did you mean {close[0]}?" if close else ""
