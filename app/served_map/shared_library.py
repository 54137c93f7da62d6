"""One library that many ask at once: its tables with their encoders, made when they are first needed."""

from __future__ import annotations

import threading
from hashlib import sha256
from pathlib import Path
from typing import Any

from app.library.answer import answer_json
from app.library.ask import like_vector, text_encoder
from app.library.map_search import MapSearch, Wanted
from app.library.report import map_list
from app.library.tables.instance_library import InstanceLibrary, InstanceTable
from app.library.thumbnails import thumbnail
from app.page.html import page_html
from app.page.payload import page_payload
from app.served_map.asked_map import NoSuchInstance
from app.served_map.library_models import LibraryAnswerRecord, LibraryHitRecord, LibraryQuery
from razer.errors import BadInput
from razer.plugins import Trust


class SharedLibrary:
    """Answers questions; safe from several threads. What others add or remove is seen by the next question."""

    def __init__(self, uri: str, trust: Trust) -> None:
        """Open a library; raises BadInput."""
        self.uri, self._trust = uri, trust
        self._library = InstanceLibrary(uri)
        self._lock = threading.Lock()
        self._searches: dict[str, MapSearch] = {}
        self._runs: dict[str, str] = {}

    def ask(self, query: LibraryQuery) -> LibraryAnswerRecord:
        """What a text means, or what looks like an instance; raises BadInput."""
        if (query.text is None) == (query.like is None):
            raise BadInput("give either a text to look for, or an instance with like: RUN:ID")
        wanted = Wanted(query.limit, query.where)
        if query.text is not None:
            answer = self._search(self._library.table(query.table)).by_text(query.text, wanted)
        else:
            found = like_vector(self._library, query.like or "", query.table)
            answer = MapSearch(found.table, None).by_vector(found.vector, found.not_itself(wanted))
        asked = query.text or query.like or ""
        record = answer_json(asked, answer, by_scene=query.by_scene)
        hits = [
            LibraryHitRecord.model_validate(hit | {"map": f"/maps/{map_key(hit['run'])}"}) for hit in record["hits"]
        ]
        return LibraryAnswerRecord(**(record | {"hits": hits}), statement=_statement(asked, len(hits)))

    def maps(self) -> list[dict[str, Any]]:
        """All maps; raises BadInput."""
        return map_list(self.uri)

    def picture(self, key: str, instance_id: int) -> bytes:
        """The thumbnail of an instance of a map, as JPEG; raises NoSuchInstance."""
        found = thumbnail(self.uri, self._run(key), instance_id)
        if found is None:
            raise NoSuchInstance(f"there is no picture of instance {instance_id} of this map")
        return found

    def page(self, key: str) -> str:
        """The page of a map of the library, by its key; raises NoSuchInstance where it is not here."""
        run = Path(self._run(key))
        if not run.is_dir():
            raise NoSuchInstance(f"the map {run} does not lie on this machine")
        return page_html("inline", page_payload(run), f"{run.name} · RAZER")

    def _run(self, key: str) -> str:
        if key not in self._runs:
            self._runs = {map_key(each["run"]): each["run"] for each in self.maps()}
        if key not in self._runs:
            raise NoSuchInstance("this library has no such map")
        return self._runs[key]

    def _search(self, table: InstanceTable) -> MapSearch:
        with self._lock:
            name = table.model.table
            if name not in self._searches:
                encoder = text_encoder(table.model.settings.with_trust(self._trust))
                self._searches[name] = MapSearch(table, encoder)
            return self._searches[name]


def map_key(run: str) -> str:
    """What the address of a map's page has of its run."""
    return sha256(run.encode()).hexdigest()[:16]


def _statement(query: str, n_hits: int) -> str:
    if n_hits == 0:
        return f"not in any of these maps: {query}"
    return f"{n_hits} {'instance' if n_hits == 1 else 'instances'} in these maps: {query}"
