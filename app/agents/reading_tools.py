"""Tools that read a map; what they answer is what the HTTP interface answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, TypeVar

import anyio.to_thread
from mcp.server.mcpserver import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp_types import ToolAnnotations
from pydantic import Field, ValidationError

from app.served_map.answer_models import MAX_HITS, MAX_TEXT, QueryAnswer, RelationList, SceneGraph
from app.served_map.asked_map import AskedMap
from app.served_map.instance_models import InstanceDetail, InstanceFilter, InstanceId, InstanceList, Kind
from app.served_map.shared_map import SharedMap
from razer.errors import BadInput

T = TypeVar("T")
READS = ToolAnnotations(read_only_hint=True, open_world_hint=False)
INSTRUCTIONS = (
    "A 3D map of a real place, made from a depth camera's recording. It knows instances: things, and stuff such as "
    "walls and floors, each with an id, a name with its probability, an oriented box in metres and spatial relations. "
    "Ask `query` where something is: it says *not in this map* where nothing fits. The map's `epoch` counts edits."
)


async def in_thread(work: Callable[[], T]) -> T:
    """What `work` gives, without holding up other requests; what is wrong with the input is told to the agent."""
    try:
        return await anyio.to_thread.run_sync(work)
    except ValidationError as error:
        raise ToolError("; ".join(fault["msg"] for fault in error.errors()[:5])) from error
    except BadInput as error:
        raise ToolError(str(error)) from error


def add_reading_tools(server: MCPServer, shared: SharedMap) -> None:
    """Register list_objects, get_object, query, relations and scene_graph."""

    async def ask(question: Callable[[AskedMap], T]) -> T:
        return await in_thread(lambda: question(shared.current))

    @server.tool(annotations=READS)
    async def list_objects(
        class_name: Annotated[str | None, Field(max_length=200, description='Only those called so: "chair".')] = None,
        kind: Annotated[Kind | None, Field(description="Only things, or only stuff (walls, floors).")] = None,
        min_score: Annotated[float, Field(ge=0, le=1, description="Least confidence that it exists.")] = 0.0,
        text: Annotated[str | None, Field(max_length=200, description="Part of a name.")] = None,
        offset: Annotated[int, Field(ge=0)] = 0,
        limit: Annotated[int, Field(ge=1, le=1000)] = 100,
    ) -> InstanceList:
        """List the instances of the map with names, positions and sizes in metres; a page of them at a time."""
        wanted = InstanceFilter(
            class_=class_name, kind=kind, min_score=min_score, text=text, offset=offset, limit=limit
        )
        return await ask(lambda current: current.listed(wanted))

    @server.tool(annotations=READS)
    async def get_object(id: InstanceId) -> InstanceDetail:
        """One instance by its id: its box, what else it may be, the frames that saw it, its relations to others."""
        return await ask(lambda current: current.detail(id))

    @server.tool(annotations=READS)
    async def query(
        text: Annotated[str, Field(min_length=1, max_length=MAX_TEXT, description='"a red chair", "furniture".')],
        limit: Annotated[int, Field(ge=1, le=MAX_HITS)] = 10,
    ) -> QueryAnswer:
        """Find what a text means, the most probable first; `statement` says *not in this map* where nothing does."""
        return await ask(lambda current: current.ask(text, limit))

    @server.tool(annotations=READS)
    async def relations() -> RelationList:
        """All spatial relations by ids: what is on, in, under, against, next to or part of what."""
        return await ask(lambda current: RelationList(epoch=current.epoch, relations=current.relations))

    @server.tool(annotations=READS)
    async def scene_graph() -> SceneGraph:
        """The whole scene: things and merged stuff as nodes with boxes, relations as edges with distances in metres."""
        return await ask(lambda current: SceneGraph(epoch=current.epoch, **current.graph))
