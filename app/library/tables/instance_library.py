"""A library: for each model a table of instances, and a table of thumbnails beside them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

import pyarrow as pa

from app.library.tables.instance_rows import schema_of
from app.library.tables.lance_tables import LancePlace, LanceTable, no_library, plain_errors, quoted
from app.library.tables.model_identity import METADATA, ModelIdentity
from razer.arrays import Float32Array
from razer.errors import BadInput

KEEP = timedelta(minutes=10)  # of versions that are not the newest: whoever reads one is done with it by then
ONE_EACH = "hypothesis = 0"
_MEASURED, _TIMES = 250, 2  # vectors, and times as many as are asked for, that an index gives to be measured exactly


@dataclass(frozen=True)
class MapEntry:
    """A map in a library: run, scene, generation, and what was noted when it was added."""

    run: str
    scene: str
    generation: int
    facts: dict[str, Any]


class InstanceTable:
    """The instances of all maps whose vectors one model made."""

    def __init__(self, model: ModelIdentity, table: LanceTable, uri: str) -> None:
        self.model, self.table, self._uri = model, table, uri
        self._counts: dict[str, int] = {}

    def add(self, rows: pa.Table, generation: int) -> None:
        """Add the rows of one map, which take the place of those that it had before; readers see these or those.
        Raises BadInput where that cannot be written."""
        run = rows["run"][0].as_py()
        with plain_errors(f"{self._uri}: {run} cannot be added"):
            self.table.append(rows, generation)
            older = f"run = {quoted(run)} AND generation < {generation}"
            if self.table.count(older):
                self.table.delete(older)

    def remove(self, run: str) -> bool:
        """Take a map out; whether it was there. Raises BadInput."""
        where = f"run = {quoted(run)}"
        with plain_errors(f"{self._uri}: {run} cannot be removed"):
            is_there = self.table.count(where) > 0
            if is_there:
                self.table.delete(where)
        return is_there

    def entries(self) -> list[MapEntry]:
        """All maps by run, each as it was added last. Raises BadInput."""
        with plain_errors(f"{self._uri} cannot be read"):
            rows = self.table.rows("provenance IS NOT NULL", ("run", "scene", "generation", "provenance"))
        newest: dict[str, MapEntry] = {}
        for row in sorted(rows.to_pylist(), key=lambda row: row["generation"]):
            newest[row["run"]] = MapEntry(row["run"], row["scene"], row["generation"], json.loads(row["provenance"]))
        return [newest[run] for run in sorted(newest)]

    def count(self, where: str | None = None) -> int:
        """How many instances pass a filter; raises BadInput for one that is none."""
        with plain_errors(f"{self._uri} cannot be read" if where is None else f"--where {where}"):
            version = self.table.version
            if self._counts.get("version") != version:
                self._counts = {"version": version}
            counted = ONE_EACH if where is None else f"({where}) AND {ONE_EACH}"
            return self._count_once(counted)

    def n_maps(self) -> int:
        """How many maps there are, as far as `count` has seen them."""
        with plain_errors(f"{self._uri} cannot be read"):
            return self._count_once("provenance IS NOT NULL")

    def _count_once(self, where: str) -> int:
        if where not in self._counts:
            self._counts[where] = self.table.count(where)
        return self._counts[where]

    def nearest(self, vectors: Float32Array, n: int, where: str | None, width: int = 1) -> pa.Table:
        """run, generation and `_distance` of the nearest rows, as `LanceTable.nearest`. Raises BadInput."""
        with plain_errors(f"{self._uri} cannot be searched"):
            return self.table.nearest(vectors, ("run", "generation"), n, where=where, width=width)

    @staticmethod
    def width(n: int) -> int:
        """How many times n vectors an index has to give, so that the n nearest are among them."""
        return max(_TIMES, -(-_MEASURED // n))

    def rows_of(self, runs: Sequence[str], columns: Sequence[str], where: str | None = None) -> dict[str, pa.Table]:
        """The rows of some maps as they were added last, by run; runs that have none are left out. Raises BadInput."""
        if not runs:
            return {}
        those = f"run IN ({', '.join(map(quoted, runs))})"
        with plain_errors(f"{self._uri} cannot be read"):
            rows = self.table.rows(those if where is None else f"{those} AND ({where})", columns)
        return dict(_newest(rows))


class InstanceLibrary:
    """The tables of one library at a URI: a folder, or a place of an object store."""

    def __init__(self, uri: str) -> None:
        """Open a library that is there; raises BadInput."""
        self.uri, self._place = uri, LancePlace(uri, must_be_there=True)
        if not self.tables:
            raise no_library(uri)

    @classmethod
    def made(cls, uri: str, model: ModelIdentity) -> InstanceTable:
        """The table of a model in a library; both are made where they are not there. Raises BadInput."""
        return InstanceTable(model, LancePlace(uri).made(model.table, schema_of(model)), uri)

    @property
    def tables(self) -> dict[str, InstanceTable]:
        """The tables of instances by name, as they are now."""
        found = {}
        for name in self._place.names:
            table = self._place.table(name)
            if model := _model_of(table):
                found[name] = InstanceTable(model, table, self.uri)
        return found

    def table(self, name: str | None) -> InstanceTable:
        """The table of that name, or the only one; raises BadInput where there is none or several."""
        tables = self.tables
        if name is not None and name not in tables:
            raise BadInput(f"{self.uri} has no table '{name}': it has {', '.join(tables)}")
        if name is None and len(tables) > 1:
            raise BadInput(
                f"{self.uri} has vectors of {len(tables)} models, which are not compared: name a table with --table, "
                f"{' or '.join(tables)}"
            )
        return tables[name or next(iter(tables))]

    def tidy(self, keep: timedelta = KEEP) -> None:
        """Write small files together, let indexes follow, and remove old versions; raises BadInput."""
        with plain_errors(f"{self.uri} cannot be compacted"):
            for name in self._place.names:
                self._place.table(name).tidy(keep)


def any_of(names: Iterable[str]) -> str:
    """The filter of instances that were called one of some names, in one of their forms."""
    return f"array_has_any(names, [{', '.join(map(quoted, sorted(set(names))))}])"


def _newest(rows: pa.Table) -> Iterator[tuple[str, pa.Table]]:
    """The rows of each run that are of its newest generation."""
    newest = rows.group_by("run").aggregate([("generation", "max")])
    for run, generation in zip(newest["run"].to_pylist(), newest["generation_max"].to_pylist(), strict=True):
        yield run, rows.filter((pa.compute.field("run") == run) & (pa.compute.field("generation") == generation))


def _model_of(table: LanceTable) -> ModelIdentity | None:
    content = (table.schema.metadata or {}).get(METADATA)
    try:
        return None if content is None else ModelIdentity.from_bytes(content)
    except (ValueError, KeyError, TypeError):
        return None
