"""The web application of one map."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from importlib import metadata

from fastapi import FastAPI
from starlette.types import ASGIApp

from app.served_map.answer_models import TextQuery
from app.server.access_rules import AccessRules
from app.server.guard import Guard
from app.server.problems import Problem, add_problem_handlers
from app.server.routes.edit_routes import edit_routes
from app.server.routes.event_routes import event_routes
from app.server.routes.instance_routes import instance_routes
from app.server.routes.page_routes import front_routes, page_routes
from app.server.routes.query_routes import query_routes
from app.server.routes.scene_routes import scene_routes
from app.server.served import Served

PREFIX = "/api/v1"
_WATCH_S = 1.0


def create_app(served: Served, rules: AccessRules | None = None) -> FastAPI:
    """The routes of a map, without who may ask them; by `rules` a token can be changed for a cookie."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        served.events.start()
        watching = asyncio.create_task(_watch(served))
        yield
        watching.cancel()
        served.events.close()

    app = documented_app("A 3D map that knows what is where: its instances, and answers about them.", lifespan)
    for routes in (instance_routes, scene_routes, page_routes, query_routes, edit_routes, event_routes):
        app.include_router(routes(served), prefix=PREFIX)
    app.include_router(front_routes(rules))
    _document_models(app)
    return app


def documented_app(
    summary: str, lifespan: Callable[[FastAPI], AbstractAsyncContextManager[None]] | None = None
) -> FastAPI:
    """An application without routes, its document at PREFIX and its problems told as all others are."""
    app = FastAPI(
        title="RAZER",
        summary=summary,
        version=metadata.version("razer"),
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,  # these pages load scripts from elsewhere
        redoc_url=None,
        redirect_slashes=False,
        lifespan=lifespan,
    )
    add_problem_handlers(app)
    return app


def guarded(served: Served, rules: AccessRules) -> ASGIApp:
    """The same behind what every request has to pass."""
    return Guard(create_app(served, rules), rules)


async def _watch(served: Served) -> None:
    """Let the map be tended, also while nobody asks for it."""
    while True:
        await asyncio.sleep(_WATCH_S)
        with suppress(Exception):
            await served.slow.run(served.source.tend)


def _document_models(app: FastAPI) -> None:
    """Add the models to the document that no route names by itself."""
    make = app.openapi

    def openapi() -> dict:
        document = make()
        schemas = document.setdefault("components", {}).setdefault("schemas", {})
        for model in (Problem, TextQuery):
            schemas.setdefault(model.__name__, model.model_json_schema(ref_template="#/components/schemas/{model}"))
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        return document

    app.openapi = openapi  # type: ignore[method-assign]
