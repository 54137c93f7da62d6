"""Routes of the page itself: its HTML, its data, what changed of a growing mesh."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from app.page.html import page_html, page_policy
from app.server.access_rules import COOKIE, AccessRules
from app.server.problems import Refusal, Responses, documented
from app.server.routes.large_answer import large_answer
from app.server.served import Served

_BYTES = {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}
_DATA: Responses = {200: _BYTES, 304: {"description": "Not changed since the ETag that was sent."}}
_CHANGES: Responses = {200: _BYTES}
_PACKET = "application/octet-stream"


def page_routes(served: Served) -> APIRouter:
    """The routes of one map."""
    router = APIRouter(tags=["page"])

    @router.get("/page", responses={**documented(), **_DATA}, response_class=Response, operation_id="get_page_data")
    async def page(request: Request) -> Response:
        """What the page shows, in its own compressed form; the ETag changes with the map."""

        def answer() -> tuple[bytes, str]:
            tag = served.source.current.tag
            return served.source.page(), f"page-{tag}"

        content, tag = await served.slow.run(answer)
        return large_answer(request, content, _PACKET, tag)

    @router.get(
        "/mesh/changes",
        responses={**documented(404), **_CHANGES},
        response_class=Response,
        operation_id="get_mesh_changes",
    )
    async def changes(request: Request, since: Annotated[int, Query(ge=0, lt=2**53)]) -> Response:
        """Blocks of a growing mesh that changed after a revision, in the page's form; 404 for a finished map."""
        content = await served.slow.run(lambda: served.source.changes(since))
        return large_answer(request, content, _PACKET, "changes")

    return router


def front_routes(rules: AccessRules | None) -> APIRouter:
    """The page; with `rules` that ask for a token, one in the address becomes a cookie."""
    router = APIRouter(include_in_schema=False)
    headers = {"content-security-policy": f"{page_policy('served')}; frame-ancestors 'none'"}

    @router.get("/")
    async def front(token: str | None = None) -> Response:
        if token is not None and rules is not None and rules.token is not None:
            return signed_in(rules, token)
        return HTMLResponse(page_html("served"), headers=headers)

    return router


def signed_in(rules: AccessRules, token: str) -> Response:
    """The page again, with a cookie in place of the token in its address; raises Refusal 401 for a wrong one."""
    if not rules.admits(token):
        raise Refusal(401, "this is not the token", headers={"www-authenticate": "Bearer"})
    response = RedirectResponse("/", 303)
    response.set_cookie(COOKIE, token, httponly=True, samesite="strict", path="/")
    return response
