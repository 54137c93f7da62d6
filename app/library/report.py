"""What a library holds, as JSON and as tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import fsspec
from rich.table import Column, Table

from app.console.streams import print_notes, result_console
from app.library.add_run import run_name
from app.library.run_state import run_state
from app.library.tables.instance_library import InstanceLibrary
from app.library.tables.lance_tables import address_of
from app.library.thumbnails import forget_thumbnails
from razer.errors import BadInput


def map_list(uri: str) -> list[dict[str, Any]]:
    """All maps by table and run: run, scene, table, state as `run_state` says, and what was noted when it was added.
    Raises BadInput."""
    return [
        {"run": entry.run, "scene": entry.scene, "table": name, "state": run_state(entry), **entry.facts}
        for name, table in InstanceLibrary(uri).tables.items()
        for entry in table.entries()
    ]


def print_maps(maps: Sequence[dict[str, Any]]) -> None:
    """Print a row for each map."""
    run, model = (Column(name, overflow="fold") for name in ("run", "table"))
    table = Table("scene", run, "instances", model, "added", "run now")
    for each in maps:
        instances, state = str(each["instances"]), each["state"]
        table.add_row(each["scene"], each["run"], instances, each["table"], each["added"], state)
    result_console().print(table)
    if any(each["state"] == "changed since" for each in maps):
        print_notes(["runs that were changed since are found as they were: add them again"])


def remove_runs(runs: Sequence[str], uri: str) -> list[str]:
    """Remove maps; their runs as the library called them, each once. Raises BadInput for one that is not there, before
    any is removed."""
    tables = InstanceLibrary(uri).tables.values()
    there = {entry.run for table in tables for entry in table.entries()}
    names = {run if run in there else run_name(Path(run)): run for run in runs}
    if absent := [run for name, run in names.items() if name not in there]:
        raise BadInput(f"{uri} has no map of {absent[0]}: razer library list --library {uri} shows them")
    for name in names:
        for table in tables:
            table.remove(name)
        forget_thumbnails(uri, name)
    return [*names]


def compacted(uri: str) -> dict[str, Any]:
    """Compact a library, and what it holds then. Raises BadInput."""
    InstanceLibrary(uri).tidy()
    return library_stats(uri)


def library_stats(uri: str) -> dict[str, Any]:
    """Tables with model, version, maps, scenes, instances, and how many of these an index covers; bytes of all versions
    that are kept, None where they cannot be told. Raises BadInput."""
    tables = []
    for name, table in InstanceLibrary(uri).tables.items():
        entries = table.entries()
        tables.append(
            {
                "table": name,
                "model": table.model.name,
                "version": table.model.version,
                "dimension": table.model.dimension,
                "maps": len(entries),
                "scenes": len({entry.scene for entry in entries}),
                "instances": table.count(),
                "indexed": table.table.has_index(),
                "unindexed_rows": table.table.n_unindexed(),
            }
        )
    return {"library": uri, "bytes": _n_bytes(uri), "tables": tables}


def print_stats(stats: dict[str, Any]) -> None:
    """Print a row for each table."""
    table = Table("table", "maps", "scenes", "instances", "search")
    for each in stats["tables"]:
        search = f"indexed, but for {each['unindexed_rows']:,}" if each["indexed"] else "exact"
        numbers = (f"{each[name]:,}" for name in ("maps", "scenes", "instances"))
        table.add_row(each["table"], *numbers, search)
    result_console().print(table)
    if stats["bytes"] is not None:
        result_console().print(f"{stats['bytes'] / 2**20:,.1f} MB in {stats['library']}", soft_wrap=True)


def _n_bytes(uri: str) -> int | None:
    try:
        files, root = fsspec.core.url_to_fs(address_of(uri))
        return int(files.du(root))
    except (OSError, ValueError, ImportError):
        return None
