"""Tools that change a map, each for the epoch that the agent saw; only where they are allowed."""

from __future__ import annotations

from typing import Annotated

from mcp.server.mcpserver import MCPServer
from mcp_types import ToolAnnotations
from pydantic import Field

from app.agents.reading_tools import in_thread
from app.served_map.edit_models import (
    Author,
    DeleteRequest,
    EditDone,
    Epoch,
    MergeRequest,
    MoveBorderRequest,
    RelabelRequest,
    RenameRequest,
    SplitRequest,
)
from app.served_map.instance_models import InstanceId
from app.served_map.shared_map import SharedMap
from razer.edits.edit import MAX_NAME
from razer.edits.region import Region

CHANGES = ToolAnnotations(read_only_hint=False, destructive_hint=False, open_world_hint=False)
TAKES_AWAY = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)  # until it is undone
Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME)]
AGENT = "agent"


def add_editing_tools(server: MCPServer, shared: SharedMap) -> None:
    """Register rename_object, relabel_object, merge_objects, delete_object, split_object, move_border, undo, redo."""
    _add_names(server, shared)
    _add_shapes(server, shared)
    _add_steps(server, shared)


def _add_names(server: MCPServer, shared: SharedMap) -> None:
    @server.tool(annotations=CHANGES)
    async def rename_object(id: InstanceId, name: Name, epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Give an instance another name; a thing stays a thing. Refused if it was changed after `epoch`."""
        return await in_thread(lambda: shared.edit(RenameRequest(instance=id, name=name, epoch=epoch, author=author)))

    @server.tool(annotations=CHANGES)
    async def relabel_object(id: InstanceId, class_name: Name, epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Give an instance another class, which says whether it is stuff, too. Refused if changed after `epoch`."""
        return await in_thread(
            lambda: shared.edit(RelabelRequest(instance=id, class_name=class_name, epoch=epoch, author=author))
        )


def _add_shapes(server: MCPServer, shared: SharedMap) -> None:
    @server.tool(annotations=TAKES_AWAY)
    async def merge_objects(
        ids: Annotated[list[InstanceId], Field(min_length=2, max_length=1000)], epoch: Epoch, author: Author = AGENT
    ) -> EditDone:
        """Let the first instance take in the others, which are no more. Refused if one was changed after `epoch`."""
        return await in_thread(lambda: shared.edit(MergeRequest(instances=ids, epoch=epoch, author=author)))

    @server.tool(annotations=TAKES_AWAY)
    async def delete_object(id: InstanceId, epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Remove an instance; its surface becomes nobody's. Refused if it was changed after `epoch`."""
        return await in_thread(lambda: shared.edit(DeleteRequest(instance=id, epoch=epoch, author=author)))

    @server.tool(annotations=CHANGES)
    async def split_object(id: InstanceId, region: Region, epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Make what of an instance lies in a region (the side n.x >= offset_m of a plane, metres) one of its own."""
        return await in_thread(
            lambda: shared.edit(SplitRequest(instance=id, region=region, epoch=epoch, author=author))
        )

    @server.tool(annotations=CHANGES)
    async def move_border(
        from_id: InstanceId, to_id: InstanceId, region: Region, epoch: Epoch, author: Author = AGENT
    ) -> EditDone:
        """Give what of one instance lies in a region to another that touches it."""
        return await in_thread(
            lambda: shared.edit(
                MoveBorderRequest(source=from_id, target=to_id, region=region, epoch=epoch, author=author)
            )
        )


def _add_steps(server: MCPServer, shared: SharedMap) -> None:
    @server.tool(annotations=CHANGES)
    async def undo(epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Take back the last edit. Refused if another came after `epoch`."""
        return await in_thread(lambda: shared.undo(author, epoch))

    @server.tool(annotations=CHANGES)
    async def redo(epoch: Epoch, author: Author = AGENT) -> EditDone:
        """Do again what was undone last. Refused if another edit came after `epoch`."""
        return await in_thread(lambda: shared.redo(author, epoch))
