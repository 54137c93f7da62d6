"""Errors as problem+json (RFC 9457): what went wrong, in one object, whatever went wrong."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.routing import Match

from app.served_map.asked_map import NoSuchInstance
from razer.errors import BadInput, EditConflict

Responses = dict[int | str, dict[str, Any]]
MEDIA_TYPE = "application/problem+json"
_MAX_DETAIL = 500
_PHRASES = {413: "Content Too Large", 421: "Misdirected Request", 422: "Unprocessable Content"}


class Problem(BaseModel):
    """An error."""

    type: str = Field("about:blank", description='"stale" where an edit comes too late.')
    title: str = Field(examples=["Not Found"])
    status: int = Field(examples=[404])
    detail: str = Field(examples=["there is no instance 7 in this map"])


class Refusal(HTTPException):
    """A request that is refused, with the reason in plain words."""

    def __init__(self, status: int, detail: str, kind: str = "about:blank", headers: dict[str, str] | None = None):
        super().__init__(status, detail, headers)
        self.kind = kind


def problem(status: int, detail: str, kind: str = "about:blank", headers: dict[str, str] | None = None) -> JSONResponse:
    """The response to a request that failed."""
    title = kind if kind != "about:blank" else _phrase(status)
    content = Problem(type=kind, title=title, status=status, detail=detail[:_MAX_DETAIL])
    return JSONResponse(content.model_dump(), status, headers, MEDIA_TYPE)


def _phrase(status: int) -> str:
    return _PHRASES.get(status) or HTTPStatus(status).phrase


def documented(*statuses: int) -> Responses:
    """The responses of a route that are problems, as its document lists them; those that any route may have, too."""
    always = (400, 401, 403, 408, 413, 421, 422, 429, 431, 503)
    return {status: _documented(status) for status in sorted({*always, *statuses})}


def _documented(status: int) -> dict[str, Any]:
    schema = {"schema": {"$ref": "#/components/schemas/Problem"}}
    return {"description": _phrase(status), "content": {MEDIA_TYPE: schema}}


def add_problem_handlers(app: FastAPI) -> None:
    """Answer every error of an app with a problem."""

    @app.exception_handler(HTTPException)
    async def of_status(request: Request, error: HTTPException) -> JSONResponse:
        kind = error.kind if isinstance(error, Refusal) else "about:blank"
        detail = error.detail if isinstance(error, Refusal) else _detail(request, error)
        headers = {"Allow": _allowed(app, request)} if error.status_code == 405 else dict(error.headers or {})
        return problem(error.status_code, detail, kind, headers)

    @app.exception_handler(RequestValidationError)
    async def of_validation(request: Request, error: RequestValidationError) -> JSONResponse:
        return problem(422, "; ".join(_fault(fault) for fault in error.errors()[:5]))

    @app.exception_handler(NoSuchInstance)
    async def of_instance(request: Request, error: NoSuchInstance) -> JSONResponse:
        return problem(404, str(error))

    @app.exception_handler(EditConflict)
    async def of_conflict(request: Request, error: EditConflict) -> JSONResponse:
        return problem(409, str(error), "stale")

    @app.exception_handler(BadInput)
    async def of_input(request: Request, error: BadInput) -> JSONResponse:
        return problem(422, str(error))


def _allowed(app: FastAPI, request: Request) -> str:
    """The methods of all routes at an address: the framework names those of one."""

    def takes(method: str) -> bool:
        scope = {**request.scope, "method": method}
        return any(route.matches(scope)[0] == Match.FULL for route in app.routes)

    return ", ".join(filter(takes, ("DELETE", "GET", "PATCH", "POST", "PUT")))


def _detail(request: Request, error: HTTPException) -> str:
    if error.status_code == 404:
        return "there is nothing at this address"
    if error.status_code == 405:
        return f"{request.method} is not what this address takes"
    return str(error.detail)


def _fault(fault: dict[str, Any]) -> str:
    where = ".".join(str(part) for part in fault["loc"])
    return f"{where}: {fault['msg']}"
