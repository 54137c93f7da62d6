"""Routes that read instances and their pictures."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from app.served_map.instance_models import InstanceDetail, InstanceFilter, InstanceId, InstanceList
from app.server.problems import Responses, documented
from app.server.served import Served

_PathId = Annotated[InstanceId, Path(examples=[12])]
_CropNumber = Annotated[int, Path(ge=0, le=100, description="0 is the best.")]
_JPEG: Responses = {200: {"content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}}}


def instance_routes(served: Served) -> APIRouter:
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

    return router
