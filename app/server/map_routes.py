"""Routes that read the map: instances and their pictures, relations, mesh."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response

from app.served_map.answer_models import RelationList, SceneGraph
from app.served_map.instance_models import InstanceDetail, InstanceFilter, InstanceId, InstanceList
from app.server.large_answer import large_answer
from app.server.problems import Responses, documented
from app.server.served import Served

_PathId = Annotated[InstanceId, Path(examples=[12])]
_CropNumber = Annotated[int, Path(ge=0, le=100, description="0 is the best.")]
_JPEG: Responses = {200: {"content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}}}
_GLB: Responses = {200: {"content": {"model/gltf-binary": {"schema": {"type": "string", "format": "binary"}}}}}
_UNCHANGED: Responses = {304: {"description": "Not changed since the ETag that was sent."}}


def map_routes(served: Served) -> APIRouter:
    """The routes of one map."""
    router = APIRouter(tags=["map"])

    @router.get("/instances", responses=documented(), operation_id="list_instances")
    async def instances(wanted: Annotated[InstanceFilter, Query()]) -> InstanceList:
        """List instances, filtered, a page of them at a time."""
        return await served.pool.run(lambda: served.source.current.listed(wanted))

    @router.get("/instances/{instance}", responses=documented(404), operation_id="get_instance")
    async def instance(instance: _PathId) -> InstanceDetail:
        """One instance with its relations."""
        return await served.pool.run(lambda: served.source.current.detail(instance))

    @router.get(
        "/instances/{instance}/crop/{number}.jpg",
        responses={**documented(404), **_JPEG},
        response_class=Response,
        operation_id="get_crop",
    )
    async def crop(instance: _PathId, number: _CropNumber) -> Response:
        """A picture of an instance, cut out of the recording."""
        content = await served.pool.run(lambda: served.source.current.crop(instance, number))
        return Response(content, media_type="image/jpeg", headers={"cache-control": "private, max-age=3600"})

    @router.get("/relations", responses=documented(), operation_id="list_relations")
    async def relations() -> RelationList:
        """What is on, in, under, against, next to and part of what."""

        def answer() -> RelationList:
            current = served.source.current
            return RelationList(epoch=current.epoch, relations=current.relations)

        return await served.pool.run(answer)

    @router.get("/scene_graph", responses=documented(), operation_id="get_scene_graph")
    async def graph() -> SceneGraph:
        """Things and merged stuff as nodes, relations as edges."""

        def answer() -> SceneGraph:
            current = served.source.current
            return SceneGraph(epoch=current.epoch, **current.graph)

        return await served.pool.run(answer)

    @router.get(
        "/mesh.glb", responses={**documented(), **_GLB, **_UNCHANGED}, response_class=Response, operation_id="get_mesh"
    )
    async def mesh(request: Request) -> Response:
        """The mesh as binary glTF, a node for each instance."""

        def answer() -> tuple[bytes, str]:
            current = served.source.current
            return current.glb, current.tag

        return large_answer(request, *_with_type(await served.pool.run(answer)))

    return router


def _with_type(answer: tuple[bytes, str]) -> tuple[bytes, str, str]:
    content, tag = answer
    return content, "model/gltf-binary", tag
