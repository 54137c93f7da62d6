"""Tables of LanceDB: opened, added to, searched, compacted; the one door to that library."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, TypeVar

import lancedb
import pyarrow as pa
from lancedb.index import BTree, IvfRq, LabelList

from app.library.tables.instance_rows import VECTOR
from app.object_store.place import Place, refuse_keys
from razer.arrays import Float32Array
from razer.errors import BadInput

T = TypeVar("T")
INDEX_FROM = 100_000  # rows; below, a search looks at every vector
_ROWS_PER_PARTITION = 4096
_CODE_BITS = 4  # of each dimension: docs/library.md has what fewer cost
_N_PROBES = 256
_NAMES_AT_ONCE = 100
_MOST_CHARACTERS = 400
_OF_FILTERS = {"run": BTree(), "names": LabelList()}  # indexes of what searches look up
_TRIES, _FIRST_WAIT_S = 6, 0.2
_PASSING = re.compile(
    "conflict|retry|timed? ?out|timeout|slow ?down|too many|reset|broken pipe|connection|unavailable|internal server|"
    "50[0234]",
    re.IGNORECASE,
)
logging.getLogger("lance").setLevel(logging.ERROR)


@contextmanager
def plain_errors(what: str) -> Iterator[None]:
    """Raise BadInput, one line that begins with `what`, for errors of the table or of the place where it lies."""
    try:
        yield
    except BadInput:
        raise
    except (ValueError, OSError, RuntimeError) as error:
        raise BadInput(f"{what}: {_cause(error)}") from error


def _cause(error: Exception) -> str:
    """What an error of LanceDB says, without the places in its source and the kinds of errors that it went through."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    text = re.sub(r",? ?\S*/\.?cargo/\S+|, location: .*|\s+", lambda m: " " if m[0].isspace() else "", str(error))
    text = re.sub(r"^((lance error|Invalid input|Invalid user input|Schema error|LanceError\(\w+\)):?,? ?)+", "", text)
    if said := re.findall(r'message: "([^"]+)"', text):  # of an object store: what is innermost is what happened
        return f"{said[-1]}, at the store"
    return text.strip()[:_MOST_CHARACTERS] or type(error).__name__


def quoted(text: str) -> str:
    """A text in a filter."""
    return "'" + text.replace("'", "''") + "'"


def address_of(uri: str) -> str:
    """What a user calls a place as LanceDB takes it: the full path of a folder, which it would take for another one
    where it has a ~ or is a file://. Raises BadInput for one that is empty, or has keys in it."""
    refuse_keys(uri, with_query=False)
    return uri if "://" in uri and not uri.startswith("file://") else Place.of(uri).text


def no_library(uri: str) -> BadInput:
    """Why a place cannot be asked."""
    return BadInput(f"{uri} is no library: razer library add RUN --library {uri} makes one")


class LancePlace:
    """The tables at a URI."""

    def __init__(self, uri: str, *, must_be_there: bool = False) -> None:
        """Open a place, which may hold nothing yet; raises BadInput. must_be_there: make no folder for it."""
        self.uri, address = uri, address_of(uri)
        folder = Path(address) if "://" not in address else None
        if folder is not None and folder.exists() and not folder.is_dir():
            raise BadInput(f"{uri} is a file: give a folder, or s3://BUCKET/PATH")
        if folder is not None and must_be_there and not folder.is_dir():
            raise no_library(uri)
        with plain_errors(f"{uri} cannot be opened"):
            # Each question looks for a newer version first: writers are other processes.
            self._place = lancedb.connect(address, read_consistency_interval=timedelta(0))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its tables."""
        with plain_errors(f"{self.uri} cannot be read"):
            return tuple(persistent(self._all_names))

    def _all_names(self) -> list[str]:
        names: list[str] = []
        page = self._place.list_tables(limit=_NAMES_AT_ONCE)
        while page.page_token:
            names += page.tables
            page = self._place.list_tables(page_token=page.page_token, limit=_NAMES_AT_ONCE)
        return [*names, *page.tables]

    def table(self, name: str) -> LanceTable:
        """A table that is there; raises BadInput."""
        with plain_errors(f"{self.uri}: table {name}"):
            return LanceTable(persistent(lambda: self._place.open_table(name)))

    def made(self, name: str, schema: pa.Schema) -> LanceTable:
        """A table, made where it is not there yet, by this process or another at the same time; raises BadInput."""
        with plain_errors(f"{self.uri} cannot be written to"):
            return LanceTable(persistent(lambda: self._place.create_table(name, schema=schema, exist_ok=True)))


def persistent(attempt: Callable[[], T]) -> T:
    """What `attempt` gives, tried again for a while where another writer was faster or a store is busy; raises the last
    error."""
    for number in range(_TRIES):
        try:
            return attempt()
        except (OSError, RuntimeError, ValueError) as error:
            if number == _TRIES - 1 or not _PASSING.search(str(error)):
                raise
        time.sleep(_FIRST_WAIT_S * 2**number)
    raise AssertionError


class LanceTable:
    """One table; each question sees the newest version, and one version throughout."""

    def __init__(self, table: Any) -> None:
        self._table = table

    @property
    def schema(self) -> pa.Schema:
        """Its columns."""
        return self._table.schema

    @property
    def version(self) -> int:
        """The number of the newest version."""
        return int(persistent(lambda: self._table.version))

    def count(self, where: str | None = None) -> int:
        """How many rows there are; raises ValueError for a filter that is none."""
        return int(persistent(lambda: self._table.count_rows(where)))

    def append(self, rows: pa.Table, generation: int) -> None:
        """Add rows in one version: all of them, or none where this is interrupted."""
        tries = count()

        def add() -> None:
            # An answer may get lost after the rows are in.
            if next(tries) == 0 or not self._table.count_rows(f"generation = {generation}"):
                self._table.add(rows)

        persistent(add)

    def delete(self, where: str) -> None:
        """Take rows away."""
        persistent(lambda: self._table.delete(where))

    def rows(self, where: str | None, columns: Sequence[str], limit: int | None = None) -> pa.Table:
        """Rows that pass a filter, in no order."""

        def read() -> pa.Table:
            query = self._table.search().select(list(columns)).limit(limit)
            return (query.where(where) if where else query).to_arrow()

        return persistent(read)

    def nearest(
        self,
        vectors: Float32Array,
        columns: Sequence[str],
        n: int,
        *,
        where: str | None = None,
        width: int = 1,
        exact: bool = False,
    ) -> pa.Table:
        """The rows of the nearest vectors by cosine distance to each of some (Q, D), at most n each, with `_distance`;
        exact where there is no index, or it is passed by. `width`: how many times n come from the index to be measured
        exactly."""

        def read() -> pa.Table:
            asked = vectors[0] if len(vectors) == 1 else vectors
            query = self._table.search(asked, vector_column_name=VECTOR).distance_type("cosine").limit(n)
            query = query.select([*columns, "_distance"]).refine_factor(width).minimum_nprobes(_N_PROBES)
            query = query.maximum_nprobes(_N_PROBES)
            query = query.bypass_vector_index() if exact else query
            return (query.where(where, prefilter=True) if where else query).to_arrow()

        return persistent(read)

    def has_index(self, column: str = VECTOR) -> bool:
        """Whether a column has an index."""
        return any(column in index.columns for index in self._table.list_indices())

    def n_unindexed(self) -> int:
        """How many rows the index of the vectors does not cover; all without one."""
        for index in self._table.list_indices():
            if VECTOR in index.columns and (stats := self._table.index_stats(index.name)):
                return int(stats.num_unindexed_rows)
        return self.count()

    def tidy(self, keep: timedelta) -> None:
        """Write small files together, remove versions that are older than `keep`, let indexes take in what is new, and
        make those that are lacking, last, as files that are written together would be indexed twice; readers go on."""
        self._optimize(keep)
        if self._has_made_indexes():
            self._optimize(keep)  # each index that is made leaves a version behind

    def _optimize(self, keep: timedelta) -> None:
        persistent(partial(self._table.optimize, cleanup_older_than=keep))

    def _has_made_indexes(self) -> bool:
        """Make the indexes that are lacking; whether there was one."""
        lacking = [name for name in _OF_FILTERS if name in self.schema.names and not self.has_index(name)]
        for column in lacking:
            persistent(partial(self._table.create_index, column, config=_OF_FILTERS[column]))
        if self.count() < INDEX_FROM or VECTOR not in self.schema.names or self.has_index():
            return bool(lacking)
        self._index_vectors()
        return True

    def _index_vectors(self) -> None:
        config = IvfRq(
            distance_type="cosine", num_bits=_CODE_BITS, num_partitions=max(1, self.count() // _ROWS_PER_PARTITION)
        )
        persistent(lambda: self._table.create_index(VECTOR, config=config))
