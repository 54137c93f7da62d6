"""`razer config`: every setting with its value, range and meaning."""

from __future__ import annotations

from dataclasses import asdict
from json import dumps

from rich.console import Console
from rich.padding import Padding

from app.console.streams import result_console
from app.settings.config_file import read_config
from app.settings.options import Flag, SettingOptions
from app.settings.run_config import RunConfig
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
    chosen = read_config(options.config, options.set, {}, preset=options.preset)
    settings, here = list_settings(chosen), _automatic(chosen)
    if json:
        rows = [{"name": setting.name, **asdict(setting), "here": here.get(setting.name)} for setting in settings]
        print(dumps(rows))
    elif toml:
        print(toml_text(settings), end="")
    else:
        _print_settings(settings, here, result_console())


def _automatic(chosen: RunConfig) -> dict[str, str]:
    """What "auto" stands for here, by the name of the setting."""
    from razer.models.automatic_choice import automatic_choice  # late: the catalogue is read

    choice = automatic_choice(chosen.segmenter, chosen.embedder)
    names = {"segmenter.name": choice.segmenter.name, "embedder.name": choice.embedder.name}
    asked = {"segmenter.name": chosen.segmenter.name, "embedder.name": chosen.embedder.name}
    return {key: name for key, name in names.items() if name != asked[key]}


def _print_settings(settings: list[Setting], here: dict[str, str], console: Console) -> None:
    for setting in settings:
        changed = " (changed)" if setting.value != setting.default else ""
        bounds = f"   [{setting.allowed}]" if setting.allowed else ""
        automatic = f"   here: {here[setting.name]}" if setting.name in here else ""
        console.print(f"{setting.name} = {_value_text(setting)}{bounds}{automatic}{changed}", soft_wrap=True)
        console.print(Padding(setting.meaning, (0, 0, 0, 4)))


def _value_text(setting: Setting) -> str:
    return "not set" if setting.value is None else toml_value(setting.value)
