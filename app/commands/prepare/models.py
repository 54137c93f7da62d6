"""`razer models`: catalogue and download of 2D models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from json import dumps
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.padding import Padding

from app.console.outputs import print_next
from app.console.streams import progress_console, result_console
from app.pipeline.interrupt import INTERRUPTED
from app.settings.options import Flag
from razer.errors import BadInput
from razer.models.hub.catalogue import CatalogueEntry, catalogue, entry
from razer.models.hub.model_sets import MODEL_SETS, ModelSet, entries_of


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
    for each in MODEL_SETS.values():
        console.print(f"{each.name}: {' + '.join(each.members)}, {each.megabytes} MB", soft_wrap=True)
        console.print(Padding(each.about, (0, 0, 0, 4)))
    for row in rows:
        is_cached = ", here" if row["path"] else ""
        star = (" *" if row["accept"] else "") + ("" if row["tried"] else " **")
        console.print(
            f"{row['name']}: {row['use']}, {row['megabytes']} MB, {row['licence']}{star}{is_cached}", soft_wrap=True
        )
        console.print(Padding(row["about"], (0, 0, 0, 4)))
    console.print("* has terms to accept: razer models pull NAME --accept-license", soft_wrap=True)
    console.print("** read by what its page says, and not tried with its real weights", soft_wrap=True)


def info(name: str, /, *, json: Flag = False) -> None:
    """Show where a model comes from, its licence and files, and whether it is in the cache.

    Parameters
    ----------
    name:
        A name of `razer models list`: a model, or a set such as starter.
    json:
        One line of JSON.
    """
    if json:
        print(dumps(_set_json(MODEL_SETS[name]) if name in MODEL_SETS else _entry_json(entry(name))))
        return
    console = result_console()
    if name in MODEL_SETS:
        console.print(f"{name}: {MODEL_SETS[name].about}, {MODEL_SETS[name].megabytes} MB", soft_wrap=True)
    for model in entries_of(name):
        _print_info(model, console)


def _print_info(model: CatalogueEntry, console: Console) -> None:
    described = _entry_json(model)
    for key in ("name", "about", "use", "licence", "accept", "page", "repo", "revision", "megabytes", "needs"):
        if described[key]:
            console.print(f"{key}: {described[key]}", soft_wrap=True)
    for file in described["files"]:
        known = described["sha256"].get(file)
        check = f"sha256 {known}" if known else "checked by the hub's checksum"
        console.print(f"file: {file}, {check}", soft_wrap=True)
    console.print(f"tried: {described['tried'] or 'not with its real weights'}", soft_wrap=True)
    console.print(f"here: {described['path'] or 'no; ' + model.how_to_get}", soft_wrap=True)


def pull(name: str, /, *, accept_license: Flag = False, json: Flag = False) -> int:
    """Download a model, or a set of them, from the Hugging Face Hub into its cache; resumes a broken download.

    Licence, files, sizes and checksums are shown before anything is fetched. What is in the cache is left alone where
    its checksum is right, and fetched anew where it is not.
    HF_HOME says where the cache is, HF_ENDPOINT names a mirror, HF_HUB_OFFLINE=1 forbids the network.

    Parameters
    ----------
    name:
        A name of `razer models list`: a model, or a set such as starter.
    accept_license:
        Accept the terms of the licence, where it has any that not everyone can meet.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    models, console = entries_of(name), progress_console()
    for model in models:
        terms = f": {model.accept}" if model.accept else ""
        console.print(
            f"{model.name}: licence {model.licence}{terms} ({model.page}), {model.megabytes} MB", soft_wrap=True
        )
        if model.accept and not accept_license:
            raise BadInput(f"{model.name} is under {model.licence}{terms}; add --accept-license if you accept that")
    if len(models) > 1:
        console.print(f"{name}: {sum(model.megabytes for model in models)} MB in all")
    try:
        paths = _fetch_all(models, console)
    except KeyboardInterrupt:
        console.print(f"interrupted: run 'razer models pull {name}' again to go on")
        return INTERRUPTED
    if json:
        print(dumps(_set_json(MODEL_SETS[name]) if name in MODEL_SETS else _entry_json(models[0])))
        return 0
    console.print(_how_to_use(name, models), soft_wrap=True)
    for path in paths:
        result_console().print(str(path), soft_wrap=True)
    print_next(("models", "info", name))
    return 0


def _fetch_all(models: Sequence[CatalogueEntry], console: Console) -> list[Path]:
    """Show what is lacking, then fetch it."""
    # Late: the hub's library takes a moment to load.
    from razer.models.hub.checksum import checksum_kind
    from razer.models.hub.download import fetch, remote_files, require_room, whole_model

    def report(line: str) -> None:
        console.print(line, soft_wrap=True)

    lacking = [model for model in models if whole_model(model, report) is None]
    for model in models:
        if model not in lacking:
            console.print(f"{model.name}: here already")
    files = [(model, file) for model in lacking for file in remote_files(model)]
    for model, file in files:
        check = f"{checksum_kind(file.published) or 'checksum'} {file.published}"
        console.print(f"{model.name}: {file.name}, {file.n_bytes / 1e6:.1f} MB, {check}", soft_wrap=True)
    if len(models) > 1:
        n_bytes = sum(file.n_bytes for _, file in files)
        console.print(f"to fetch: {n_bytes / 1e6:.1f} MB in {len(files)} files", soft_wrap=True)
    require_room(files)
    return [fetch(model, report) for model in models]


def _how_to_use(name: str, models: Sequence[CatalogueEntry]) -> str:
    needs = any(model.needs for model in models)
    package = " (needs the extra: pip install 'razer[transformers]')" if needs else ""
    if name in MODEL_SETS:
        return f"`razer run` uses them where no --segmenter and --embedder are named{package}"
    model = models[0]
    settings = [f"weights={model.name}", *model.also]
    more = " ".join(f"--set {model.task}.options.{setting}" for setting in settings)
    return f"use it with --{model.use} {more}{package}"


def _set_json(models: ModelSet) -> dict[str, Any]:
    return {**asdict(models), "megabytes": models.megabytes, "models": [_entry_json(each) for each in models.entries]}


def _entry_json(model: CatalogueEntry) -> dict[str, Any]:
    """An entry as JSON has it, with `path` where it is in the cache, and the sets it is in."""
    from razer.models.hub.cache import cached_model  # late, as in `pull`

    path = cached_model(model)
    sets = [each.name for each in MODEL_SETS.values() if model.name in each.members]
    return {**asdict(model), "path": None if path is None else str(path), "sets": sets}
