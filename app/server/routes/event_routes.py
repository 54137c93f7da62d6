"""The route that tells of changes as they happen."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from app.server.problems import Responses, documented
from app.server.served import Served

_STREAM: Responses = {200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}}


def event_routes(served: Served) -> APIRouter:
    """The route of one map."""
    router = APIRouter(tags=["events"])

    @router.get("/events", responses={**documented(), **_STREAM}, response_class=Response, operation_id="stream_events")
    async def events() -> Response:
        """Server-sent events: `map` {epoch, frame, revision}, `instance` {id, name, born_frame}, `edit` {epoch, kind,
        author}; a comment every 15 seconds."""
        return served.events.response()

    return router
