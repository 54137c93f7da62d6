"""Routes by which people change the map: edits, undo, redo."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Query

from app.served_map.edit_models import Author, EditDone, EditList, EditRequest
from app.server.problems import documented
from app.server.served import Served

_Author = Annotated[Author, Query()]
_Epoch = Annotated[int | None, Query(ge=0, lt=2**53, description="That of the map which the author saw.")]


def edit_routes(served: Served) -> APIRouter:
    """The routes of one map."""
    router = APIRouter(tags=["edits"])

    @router.get("/edits", responses=documented(), operation_id="list_edits")
    async def edits() -> EditList:
        """The edit log, oldest first."""
        return await served.pool.run(lambda: served.source.edits)

    @router.post("/edits", status_code=201, responses=documented(409), operation_id="edit")
    async def edit(request: Annotated[EditRequest, Body()]) -> EditDone:
        """Change the map; refused as stale where an instance was changed since the epoch that the author saw."""
        return await served.pool.run(lambda: served.source.edit(request))

    @router.delete("/edits/last", responses=documented(409), operation_id="undo")
    async def undo(author: _Author = "", epoch: _Epoch = None) -> EditDone:
        """Take back the last edit that is in force."""
        return await served.pool.run(lambda: served.source.undo(author, epoch))

    @router.post("/edits/redo", responses=documented(409), operation_id="redo")
    async def redo(author: _Author = "", epoch: _Epoch = None) -> EditDone:
        """Do again what was undone last."""
        return await served.pool.run(lambda: served.source.redo(author, epoch))

    return router
