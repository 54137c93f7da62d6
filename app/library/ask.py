"""Asking a library a question from outside: by text, by a picture, by an instance of a map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from app.library.add_run import run_name
from app.library.known_texts import KnownTexts
from app.library.map_search import LibraryAnswer, MapSearch, Wanted
from app.library.search_options import SearchOptions
from app.library.tables.instance_library import InstanceLibrary, InstanceTable
from app.library.tables.stored_map import COLUMNS, StoredMap
from app.query.negative_prompt_cache import negative_prompts_of
from app.query.query_image import embed_query_image
from app.settings.config_file import read_run_config
from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.models import embedder_of
from razer.plugins import EmbedderSettings, Trust
from razer.query.text_queries import TextQueryEncoder


def ask(uri: str, text: str | None, search: SearchOptions, trust: Trust) -> LibraryAnswer:
    """The answer of the library at a URI to a text, or to what the options name in its place. Raises BadInput."""
    library = InstanceLibrary(uri)
    wanted = Wanted(search.k, search.where, search.min_score)
    if search.like is not None:
        found = like_vector(library, search.like, search.table)
        return MapSearch(found.table, None).by_vector(found.vector, found.not_itself(wanted))
    table = library.table(search.table)
    settings = embedder_settings(table, search.embedder, search.set, trust)
    if text is not None:
        return MapSearch(table, text_encoder(settings)).by_text(text, wanted)
    assert search.image is not None
    vector = embed_query_image(embedder_of(settings), settings.name, search.image, search.box)
    return MapSearch(table, None).by_vector(vector, wanted)


def text_encoder(settings: EmbedderSettings) -> KnownTexts:
    """What encodes texts; raises BadInput where the embedder knows no words."""
    encoder = TextQueryEncoder(embedder_of(settings))
    negatives = negative_prompts_of(encoder, settings)
    return KnownTexts(encoder.embedder, negatives)


def embedder_settings(
    table: InstanceTable, embedder: str | None, assignments: tuple[str, ...], trust: Trust
) -> EmbedderSettings:
    """The embedder of a table, or the one that the command line names. Raises BadInput."""
    if embedder is None and not assignments:
        return table.model.settings.with_trust(trust)
    named = {"embedder.name": embedder or table.model.name}
    return read_run_config(None, assignments, named if embedder else {}, trust=trust).embedder


@dataclass(frozen=True)
class Liked:
    """An instance of a library that others are to be like: its map, id, table and vector (D,)."""

    run: str
    id: int
    table: InstanceTable
    vector: Float32Array

    def not_itself(self, wanted: Wanted) -> Wanted:
        """What is wanted, but for the instance itself."""
        return replace(wanted, not_this=(self.run, self.id))


def like_vector(library: InstanceLibrary, like: str, name: str | None) -> Liked:
    """The instance that RUN:ID names, in a table or in any; raises BadInput."""
    run, separator, number = like.rpartition(":")
    if not separator or not (number.isascii() and number.isdigit()):
        raise BadInput(f"--like {like}: write it as RUN:ID")
    table, stored = _map_of(library, run, name)
    objects = {item.id: item for item in (*stored.queries.objects, *stored.queries.parts)}
    if int(number) not in objects:
        raise BadInput(f"--like {like}: that map has no instance {number}")
    vectors = objects[int(number)].embeddings
    if not len(vectors):
        raise BadInput(f"--like {like}: nothing is known of its looks")
    return Liked(stored.run, int(number), table, vectors[0])


def _map_of(library: InstanceLibrary, run: str, name: str | None) -> tuple[InstanceTable, StoredMap]:
    """A map by what the user calls it, with its table; raises BadInput where no table has it."""
    tables = [library.table(name)] if name else list(library.tables.values())
    for called in dict.fromkeys((run, run_name(Path(run)))):
        for table in tables:
            if rows := table.rows_of([called], COLUMNS):
                return table, StoredMap.of(rows[called], None)
    raise BadInput(f"{library.uri} has no map of {run}: razer library list --library {library.uri} shows them")
