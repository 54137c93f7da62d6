"""The route that questions go to, in words or as a picture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, ValidationError
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException

from app.served_map.answer_models import MAX_HITS, QueryAnswer, TextQuery
from app.served_map.query_picture import MAX_BYTES, decoded_picture
from app.server.problems import Refusal, documented
from app.server.served import Served
from razer.query.ranking import PRESENT

_Least = Annotated[float, Query(ge=0, le=1, description="Of a hit; lower finds more, and more that is wrong.")]
T = TypeVar("T", bound=BaseModel)
_LIMIT = {"type": "integer", "minimum": 1, "maximum": MAX_HITS, "default": 10}
_FORM = {
    "type": "object",
    "required": ["image"],
    "properties": {
        "image": {"type": "string", "format": "binary", "description": "PNG or JPEG, 10 MB at most."},
        "limit": _LIMIT,
    },
}
_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {"schema": {"$ref": "#/components/schemas/TextQuery"}},
            "multipart/form-data": {"schema": _FORM},
        },
    }
}


def query_routes(served: Served) -> APIRouter:
    """The route of one map."""
    router = APIRouter(tags=["query"])

    @router.post("/query", responses=documented(415), openapi_extra=_BODY, operation_id="query")
    async def query(request: Request, min_probability: _Least = PRESENT) -> QueryAnswer:
        """Which instances a text means, or look like a picture; says so where none does."""
        kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
        if kind == "application/json":
            asked = parsed(TextQuery, await request.body())
            return await served.pool.run(lambda: served.source.current.ask(asked.text, asked.limit, min_probability))
        if kind == "multipart/form-data":
            data, limit = await _picture_of(request)
            return await served.pool.run(_asking(served, data, limit, min_probability))
        raise Refusal(415, "send application/json with a text, or multipart/form-data with an image")

    return router


def parsed(model: type[T], body: bytes) -> T:
    """A body as a model; raises Refusal 422."""
    try:
        return model.model_validate_json(body)
    except ValidationError as error:
        faults = error.errors(include_url=False, include_input=False)[:5]
        detail = "; ".join(f"{'.'.join(['body', *map(str, fault['loc'])])}: {fault['msg']}" for fault in faults)
        raise Refusal(422, detail) from None


async def _picture_of(request: Request) -> tuple[bytes, int]:
    """The file and the limit of a form; raises Refusal."""
    try:
        async with request.form(max_files=1, max_fields=4, max_part_size=1000) as form:
            image, limit = form.get("image"), form.get("limit", "10")
            if not isinstance(image, UploadFile):
                raise Refusal(422, "the form has no file named image")
            data = await image.read(MAX_BYTES + 1)
    except Refusal:
        raise
    except HTTPException as error:
        raise Refusal(422, f"the form cannot be read: {error.detail}") from None
    if not isinstance(limit, str) or not limit.isascii() or not limit.isdigit() or not 1 <= int(limit) <= MAX_HITS:
        raise Refusal(422, f"limit: give a number from 1 to {MAX_HITS}")
    if len(data) > MAX_BYTES:
        raise Refusal(413, f"the picture is too large: {MAX_BYTES // 2**20} MB at most")
    return data, int(limit)


def _asking(served: Served, data: bytes, limit: int, least: float) -> Callable[[], QueryAnswer]:
    return lambda: served.source.current.ask_picture(decoded_picture(data), limit, least)
