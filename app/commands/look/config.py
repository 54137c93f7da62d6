"""`razer config`: every setting with its value, range and meaning."""

from __future__ import annotations

from dataclasses import asdict
from json import dumps

from rich.console import Console
from rich.padding import Padding

from app.console.streams import result_console
from app.settings.config_file import read_config
from app.settings.options import Flag, SettingOptions
from razer.storage.settings_list import Setting, list_settings
from razer.storage.toml_text import toml_text, toml_value


def config(*, options: SettingOptions = SettingOptions(), json: Flag = False, toml: Flag = False) -> None:  # noqa: B008
    """Print every setting with its value, range and meaning.

    Parameters
    ----------
    json:
        As JSON.
    toml:
        As a TOML file that --config reads.
    """
    settings = list_settings(read_config(options.config, options.set, {}, preset=options.preset))
    if json:
        print(dumps([{"name": setting.name, **asdict(setting)} for setting in settings]))
    elif toml:
        print(toml_text(settings), end="")
    else:
        _print_settings(settings, result_console())


def _print_settings(settings: list[Setting], console: Console) -> None:
    for setting in settings:
        changed = " (changed)" if setting.value != setting.default else ""
        bounds = f"   [{setting.allowed}]" if setting.allowed else ""
        console.print(f"{setting.name} = {_value_text(setting)}{bounds}{changed}", soft_wrap=True)
        console.print(Padding(setting.meaning, (0, 0, 0, 4)))


def _value_text(setting: Setting) -> str:
    return "not set" if setting.value is None else toml_value(setting.value)
