"""Routes that read the map as a whole: relations, scene graph, mesh."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from app.served_map.answer_models import RelationList, SceneGraph
from app.server.problems import Responses, documented
from app.server.routes.large_answer import large_answer
from app.server.served import Served

_GLB: Responses = {200: {"content": {"model/gltf-binary": {"schema": {"type": "string", "format": "binary"}}}}}
_UNCHANGED: Responses = {304: {"description": "Not changed since the ETag that was sent."}}


def scene_routes(served: Served) -> APIRouter:
    """The routes of one map."""
    router = APIRouter(tags=["map"])

    @router.get("/relations", responses=documented(), operation_id="list_relations")
    async def relations() -> RelationList:
        """What is on, in, under, against, next to and part of what."""

        def answer() -> RelationList:
            current = served.source.current
            return RelationList(epoch=current.epoch, relations=current.relations)

        return await served.slow.run(answer)

    @router.get("/scene_graph", responses=documented(), operation_id="get_scene_graph")
    async def graph() -> SceneGraph:
        """Things and merged stuff as nodes, relations as edges."""

        def answer() -> SceneGraph:
            current = served.source.current
            return SceneGraph(epoch=current.epoch, **current.graph)

        return await served.slow.run(answer)

    @router.get(
        "/mesh.glb", responses={**documented(), **_GLB, **_UNCHANGED}, response_class=Response, operation_id="get_mesh"
    )
    async def mesh(request: Request) -> Response:
        """The mesh as binary glTF, a node for each instance."""

        def answer() -> tuple[bytes, str]:
            current = served.source.current
            return current.glb, current.tag

        content, tag = await served.slow.run(answer)
        return large_answer(request, content, "model/gltf-binary", tag)

    return router
