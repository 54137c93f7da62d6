"""What every request passes before it is read: host, origin, token, sizes, times; and the headers of every answer."""

from __future__ import annotations

import asyncio
import time
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.served_map.query_picture import MAX_BYTES
from app.server.access_rules import COOKIE, AccessRules
from app.server.problems import Refusal, problem

MAX_BODY_BYTES = MAX_BYTES + 2**16  # a picture, and what a form adds
MAX_JSON_BYTES = 2**20
MAX_HEADER_BYTES = 2**14  # with the address; what is more than one packet of it never gets here
MAX_IN_FLIGHT = 256
BODY_TIMEOUT_S = 20.0
SEND_TIMEOUT_S = 20.0  # a client that reads nothing for so long is gone
ANSWER_TIMEOUT_S = 60.0
FAILURES_AT_ONCE, FAILURES_PER_S = 20.0, 1.0  # of tokens
_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "x-frame-options": "DENY",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_CLOSED_POLICY = "default-src 'none'; frame-ancestors 'none'"


class Guard:
    """An ASGI app that lets through to another what may pass."""

    def __init__(self, app: ASGIApp, rules: AccessRules) -> None:
        self._app, self._rules = app, rules
        self._in_flight = 0
        self._failures = _Bucket(FAILURES_AT_ONCE, FAILURES_PER_S)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self._app(scope, receive, send)
            return
        exchange = _Exchange(scope, receive, send)
        refusal = self._refusal(scope)
        if refusal is not None:
            await exchange.refuse(refusal)
            return
        self._in_flight += 1
        try:
            await exchange.answer(self._app)
        finally:
            self._in_flight -= 1

    def _refusal(self, scope: Scope) -> Refusal | None:
        headers, rules = Headers(scope=scope), self._rules
        n_bytes = (
            len(scope["raw_path"]) + len(scope["query_string"]) + sum(len(k) + len(v) for k, v in scope["headers"])
        )
        if n_bytes > MAX_HEADER_BYTES:
            return Refusal(431, f"address and headers are too large: {MAX_HEADER_BYTES // 2**10} KB at most")
        hosts = headers.getlist("host")
        if len(hosts) != 1 or not rules.knows_host(hosts[0]):
            return Refusal(421, "this server is not called that: use the address that it printed")
        origin = headers.get("origin")
        if origin is not None and not rules.knows_origin(origin, hosts[0]):
            return Refusal(403, "the request comes from a page of another server")
        if scope["method"] not in ("GET", "HEAD") and headers.get("sec-fetch-site") == "cross-site":
            return Refusal(403, "the request comes from a page of another server")
        if self._in_flight >= MAX_IN_FLIGHT:
            return Refusal(503, "too many requests at once: try again", headers={"retry-after": "1"})
        if rules.token is not None and not is_sign_in(scope) and not rules.admits(_token(headers)):
            return self.failed_token()
        return None

    def failed_token(self) -> Refusal:
        """What a wrong token, or none, is told; more of them than one a second are not even looked at closely."""
        if not self._failures.take():
            return Refusal(429, "too many wrong tokens: wait a little", headers={"retry-after": "5"})
        return Refusal(
            401,
            "a token is needed: open /?token=..., or send it as Authorization: Bearer",
            headers={"www-authenticate": "Bearer"},
        )


def _header_bytes(scope: Scope) -> int:
    of_headers = sum(len(name) + len(value) for name, value in scope["headers"])
    return len(scope["raw_path"]) + len(scope["query_string"]) + of_headers


def is_sign_in(scope: Scope) -> bool:
    """Whether a request brings its token in the address, to get a cookie for it."""
    return scope["method"] == "GET" and scope["path"] == "/" and b"token=" in scope["query_string"]


def _token(headers: Headers) -> str | None:
    scheme, _, token = headers.get("authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        return token.strip()
    try:
        cookies = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return None
    return cookies[COOKIE].value if COOKIE in cookies else None


class _Exchange:
    """One request and its answer, within bounds of size and time."""

    def __init__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self._scope, self._receive, self._send = scope, receive, send
        headers = Headers(scope=scope)
        is_form = headers.get("content-type", "").startswith("multipart/form-data")
        self._left = MAX_BODY_BYTES if is_form else MAX_JSON_BYTES
        self._declared = headers.get("content-length", "0")
        self._deadline_s = time.monotonic() + BODY_TIMEOUT_S
        self._is_read = self._declared == "0" and "transfer-encoding" not in headers
        self._has_started = False

    async def answer(self, app: ASGIApp) -> None:
        """Let an app answer; the client is told where it has not within time."""
        if self._declared.isdigit() and int(self._declared) > self._left:
            await self.refuse(_too_large())
            return
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT_S) as self._patience:
                await app(self._scope, self.receive, self.send)
        except TimeoutError:
            if self._has_started:
                raise ConnectionAbortedError("the client reads too slowly") from None
            await self.refuse(Refusal(503, "the answer took too long: try again", headers={"retry-after": "5"}))

    async def refuse(self, refusal: Refusal) -> None:
        """Answer without reading on: what is still to come of the body is not waited for."""
        headers = {**dict(refusal.headers or {}), "connection": "close"}
        await problem(refusal.status_code, refusal.detail, headers=headers)(self._scope, self._receive, self.send)

    async def receive(self) -> Message:
        """The next part of the body; raises a refusal where there is too much of it, or it comes too slowly."""
        if self._is_read:
            return await self._receive()
        try:
            async with asyncio.timeout(max(self._deadline_s - time.monotonic(), 0.0)):
                message = await self._receive()
        except TimeoutError:
            raise Refusal(408, "the request came too slowly", headers={"connection": "close"}) from None
        if message["type"] == "http.request":
            self._left -= len(message.get("body", b""))
            self._is_read = not message.get("more_body", False)
            if self._left < 0:
                raise _too_large()
        return message

    async def send(self, message: Message) -> None:
        """Send a part of the answer; raises where the client does not take it."""
        if message["type"] == "http.response.start":
            self._has_started = True
            self._patience_ends()
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
            headers.setdefault("content-security-policy", _CLOSED_POLICY)
            headers.setdefault("cache-control", "no-store")
        async with asyncio.timeout(SEND_TIMEOUT_S):
            await self._send(message)

    def _patience_ends(self) -> None:
        """A stream of events may last: only each part of it has to be taken in time."""
        if hasattr(self, "_patience"):
            self._patience.reschedule(None)


def _too_large() -> Refusal:
    detail = f"the request is too large: {MAX_BYTES // 2**20} MB for a picture, {MAX_JSON_BYTES // 2**20} for the rest"
    return Refusal(413, detail, headers={"connection": "close"})


class _Bucket:
    """So many at once, then so many a second."""

    def __init__(self, size: float, per_s: float) -> None:
        self._size, self._per_s = size, per_s
        self._level, self._seen_s = size, time.monotonic()

    def take(self) -> bool:
        """Whether there is one left."""
        now_s = time.monotonic()
        self._level = min(self._size, self._level + (now_s - self._seen_s) * self._per_s)
        self._seen_s = now_s
        if self._level < 1:
            return False
        self._level -= 1
        return True
