"""`razer models`: catalogue and download of 2D models."""

from __future__ import annotations

from dataclasses import asdict
from json import dumps
from typing import Any

from rich.padding import Padding

from app.console.streams import progress_console, result_console
from app.pipeline.interrupt import INTERRUPTED
from app.settings.options import Flag
from razer.errors import BadInput
from razer.models.hub.catalogue import CatalogueEntry, catalogue, entry


def list_models(*, json: Flag = False) -> None:
    """Show the models that can be downloaded by name.

    Parameters
    ----------
    json:
        One line of JSON.
    """
    rows = [_entry_json(model) for model in catalogue().values()]
    if json:
        print(dumps(rows))
        return
    console = result_console()
    for row in rows:
        is_cached = ", here" if row["path"] else ""
        star = " *" if row["accept"] else ""
        console.print(
            f"{row['name']}: {row['use']}, {row['megabytes']} MB, {row['licence']}{star}{is_cached}", soft_wrap=True
        )
        console.print(Padding(row["about"], (0, 0, 0, 4)))
    console.print("* has terms to accept: razer models pull NAME --accept-license", soft_wrap=True)


def info(name: str, /, *, json: Flag = False) -> None:
    """Show where a model comes from, its licence and files, and whether it is in the cache.

    Parameters
    ----------
    name:
        A name of `razer models list`.
    json:
        One line of JSON.
    """
    described = _entry_json(entry(name))
    if json:
        print(dumps(described))
        return
    console = result_console()
    for key in ("name", "about", "use", "licence", "accept", "repo", "revision", "megabytes"):
        if described[key]:
            console.print(f"{key}: {described[key]}", soft_wrap=True)
    for file in described["files"]:
        known = described["sha256"].get(file)
        check = f"sha256 {known}" if known else "checked by the hub's checksum"
        console.print(f"file: {file}, {check}", soft_wrap=True)
    console.print(f"here: {described['path'] or 'no; ' + entry(name).how_to_get}", soft_wrap=True)


def pull(name: str, /, *, accept_license: Flag = False, json: Flag = False) -> int:
    """Download a model from the Hugging Face Hub into its cache; resumes a broken download.

    HF_HOME says where the cache is, HF_ENDPOINT names a mirror, HF_HUB_OFFLINE=1 forbids the network.

    Parameters
    ----------
    name:
        A name of `razer models list`.
    accept_license:
        Accept the terms of the licence, where it has any that not everyone can meet.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    model, console = entry(name), progress_console()
    terms = f": {model.accept}" if model.accept else ""
    console.print(f"{name}: licence {model.licence}{terms}", soft_wrap=True)
    if model.accept and not accept_license:
        raise BadInput(f"{name} is under {model.licence}{terms}; add --accept-license if you accept that")

    # Late: the hub's library takes a moment to load.
    from razer.models.hub.download import fetch

    try:
        path = fetch(model, lambda line: console.print(line, soft_wrap=True))
    except KeyboardInterrupt:
        console.print(f"interrupted: run 'razer models pull {name}' again to go on")
        return INTERRUPTED
    if json:
        print(dumps(_entry_json(model)))
    else:
        settings = [f"weights={name}", *model.also]
        more = " ".join(f"--set {model.task}.options.{setting}" for setting in settings)
        console.print(f"use it with --{model.use} {more}", soft_wrap=True)
        result_console().print(str(path), soft_wrap=True)
    return 0


def _entry_json(model: CatalogueEntry) -> dict[str, Any]:
    """An entry as JSON has it, with `path` where it is in the cache."""
    from razer.models.hub.cache import cached_model  # late, as in `pull`

    path = cached_model(model)
    return {**asdict(model), "path": None if path is None else str(path)}
