"""Tools that search a library of maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from mcp.server.mcpserver import MCPServer
from pydantic import Field

from app.agents.reading_tools import READS, in_thread
from app.served_map.answer_models import MAX_HITS, MAX_TEXT
from app.served_map.library_models import MAX_FILTER, LibraryAnswerRecord, LibraryMaps, LibraryQuery

if TYPE_CHECKING:
    from app.served_map.shared_library import SharedLibrary  # it needs the extra `library`

LIBRARY_INSTRUCTIONS = (
    "A library of 3D maps of real places. Ask `search_library` in which of them something is: each hit names its map "
    "(`run`), the place (`scene`) and the instance there; it says *not in any of these maps* where nothing fits."
)


def add_library_tools(server: MCPServer, library: SharedLibrary) -> None:
    """Register search_library and list_maps."""

    @server.tool(annotations=READS)
    async def search_library(
        text: Annotated[str | None, Field(max_length=MAX_TEXT, description='"a red chair with wheels".')] = None,
        like: Annotated[str | None, Field(max_length=MAX_FILTER, description="RUN:ID, in place of a text.")] = None,
        where: Annotated[
            str | None, Field(max_length=MAX_FILTER, description="SQL: class = 'chair' and height_m < 1")
        ] = None,
        limit: Annotated[int, Field(ge=1, le=MAX_HITS)] = 10,
        by_scene: bool = False,
        table: Annotated[str | None, Field(max_length=100, description="Of several models' tables one.")] = None,
    ) -> LibraryAnswerRecord:
        """Find what a text means in all maps of the library, the most probable first, with scene, map and place."""
        return await in_thread(
            lambda: library.ask(
                LibraryQuery(text=text, like=like, where=where, limit=limit, by_scene=by_scene, table=table)
            )
        )

    @server.tool(annotations=READS)
    async def list_maps() -> LibraryMaps:
        """The maps of the library: run, scene, how many instances, when it was added, and which models made it."""
        return await in_thread(lambda: LibraryMaps(maps=library.maps()))
