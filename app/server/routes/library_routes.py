"""Routes of a library of maps: questions, its maps, their pages, and a page to ask by."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from hashlib import sha256
from html import escape
from typing import Annotated

from fastapi import APIRouter, Query, Response
from fastapi.responses import HTMLResponse

from app.page.html import page_policy
from app.served_map.answer_models import MAX_TEXT
from app.served_map.instance_models import InstanceId
from app.served_map.library_models import MAX_FILTER, LibraryAnswerRecord, LibraryMaps, LibraryQuery
from app.served_map.shared_library import SharedLibrary
from app.server.access_rules import AccessRules
from app.server.bounded_pool import BoundedPool
from app.server.problems import Responses, documented
from app.server.routes.page_routes import signed_in
from razer.errors import BadInput

_JPEG: Responses = {200: {"content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}}}
_STYLE = """body{font:16px system-ui,sans-serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#1d2329}
input{font:inherit;padding:.4rem;width:100%;box-sizing:border-box;margin:.2rem 0}
table{border-collapse:collapse;width:100%}
td,th{text-align:left;padding:.35rem .6rem;border-bottom:1px solid #d5dade}button{font:inherit;padding:.4rem 1rem}
img{max-height:4.5rem;max-width:6rem}.none{color:#8a2b1f}"""
_HASH = b64encode(sha256(_STYLE.encode()).digest()).decode()
_POLICY = (
    f"default-src 'none'; style-src 'sha256-{_HASH}'; img-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)


def library_routes(library: SharedLibrary, pool: BoundedPool) -> APIRouter:
    """The routes for programs."""
    router = APIRouter(tags=["library"])

    @router.post("/library/query", responses=documented(), operation_id="query_library")
    async def query(asked: LibraryQuery) -> LibraryAnswerRecord:
        """Which instances of all maps a text means, or look like one; says so where none does."""
        return await pool.run(lambda: library.ask(asked))

    @router.get("/library/maps", responses=documented(), operation_id="list_maps")
    async def maps() -> LibraryMaps:
        """The maps of the library."""
        return await pool.run(lambda: LibraryMaps(maps=library.maps()))

    @router.get(
        "/library/maps/{key}/instances/{instance}/thumbnail.jpg",
        responses={**documented(404), **_JPEG},
        response_class=Response,
        operation_id="get_thumbnail",
    )
    async def picture(key: str, instance: InstanceId) -> Response:
        """A small picture of an instance; `key` is the last part of a hit's `map`."""
        content = await pool.run(lambda: library.picture(key, instance))
        return Response(content, media_type="image/jpeg", headers={"cache-control": "private, max-age=3600"})

    return router


def library_pages(library: SharedLibrary, pool: BoundedPool, rules: AccessRules) -> APIRouter:
    """The pages for people."""
    router = APIRouter(include_in_schema=False)

    @router.get("/")
    async def front(
        token: str | None = None,
        q: Annotated[str, Query(max_length=MAX_TEXT)] = "",
        where: Annotated[str, Query(max_length=MAX_FILTER)] = "",
    ) -> Response:
        if token is not None and rules.token is not None:
            return signed_in(rules, token)
        answer = await pool.run(_answering(library, q, where)) if q.strip() else ""
        return HTMLResponse(_page(q, where, answer), headers={"content-security-policy": _POLICY})

    @router.get("/maps/{key}")
    async def map_page(key: str) -> Response:
        content = await pool.run(lambda: library.page(key))
        policy = f"{page_policy('inline')}; frame-ancestors 'none'"
        return HTMLResponse(content, headers={"content-security-policy": policy})

    return router


def _answering(library: SharedLibrary, text: str, where: str) -> Callable[[], str]:
    def answer() -> str:
        try:
            return _shown(library.ask(LibraryQuery(text=text, where=where or None)))
        except BadInput as error:
            return f'<p class="none">{escape(str(error))}</p>'

    return answer


def _shown(answer: LibraryAnswerRecord) -> str:
    if not answer.found:
        return f'<p class="none">{escape(answer.statement)}</p>'
    rows = [
        f"<tr><td><img alt='' loading='lazy' src='/api/v1/library{escape(hit.map)}/instances/{hit.id}/thumbnail.jpg'>"
        f"<td><a href='{escape(hit.map)}#s={hit.id}'>{escape(hit.scene)}</a><td>{hit.id}<td>{escape(hit.class_ or '-')}"
        f"<td>{hit.score:.2f}<td>{escape(hit.run)}"
        for hit in answer.hits
    ]
    heads = "<tr><th><th>scene<th>id<th>class<th>score<th>run"
    return f"<p>{escape(answer.statement)}</p><table>{heads}{''.join(rows)}</table>"


def _page(text: str, where: str, answer: str) -> str:
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>RAZER library</title><style>{_STYLE}</style>"
        "<h1>Library of maps</h1><form method='get' action='/'>"
        f"<input name='q' value='{escape(text)}' placeholder='a red chair with wheels' aria-label='What to look for'>"
        f"<input name='where' value='{escape(where)}' placeholder='height_m &lt; 1' aria-label='Filter in SQL'>"
        f"<button>Search</button></form>{answer}</html>"
    )
