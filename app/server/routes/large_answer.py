"""Large answers in pieces, so that a client that reads none of them is noticed, and with a tag, so that they are sent
once."""

from __future__ import annotations

from collections.abc import AsyncIterator

from fastapi import Request, Response
from fastapi.responses import StreamingResponse

_PIECE_BYTES = 256 * 2**10


def large_answer(request: Request, content: bytes, media_type: str, tag: str) -> Response:
    """The content, or that it has not changed since the client was given this tag."""
    headers = {"etag": f'"{tag}"', "cache-control": "no-cache"}
    if f'"{tag}"' in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    headers["content-length"] = str(len(content))
    return StreamingResponse(_pieces(content), headers=headers, media_type=media_type)


async def _pieces(content: bytes) -> AsyncIterator[bytes]:
    view = memoryview(content)
    for start in range(0, len(view), _PIECE_BYTES):
        yield bytes(view[start : start + _PIECE_BYTES])
