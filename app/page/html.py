"""The page as one HTML file: shell, style, data and script, with a policy that forbids any request elsewhere."""

from __future__ import annotations

import re
from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files
from typing import Literal

_BUNDLE = "bundle"


def page_html(source: Literal["inline", "served"], payload: bytes | None = None, title: str = "RAZER map") -> str:
    """The whole page: with its payload ("inline"), or one that asks the server that it came from ("served").

    Raises ValueError if an inline page has no payload.
    """
    if source == "inline" and payload is None:
        raise ValueError("an inline page needs a payload")
    parts = {
        "POLICY": page_policy(source),
        "TITLE": _escaped(title),
        "STYLE": _part("viewer.css"),
        "KIND": source,
        "DATA": "" if payload is None else b64encode(payload).decode(),
        "SCRIPT": _part("viewer.js"),
    }
    return re.sub(r"@([A-Z]+)@", lambda mark: parts[mark[1]], _part("page.html"))


def page_policy(source: Literal["inline", "served"]) -> str:
    """The Content-Security-Policy: scripts and styles by their hashes, pictures and the decoder made in the page, and
    requests only to the server that the page came from."""
    connect = "'self'" if source == "served" else "'none'"
    script, style = _hash(_part("viewer.js")), _hash(_part("viewer.css"))
    return (
        f"default-src 'none'; script-src {script}; style-src {style}; img-src 'self' data: blob:; "
        f"worker-src blob:; connect-src {connect}; base-uri 'none'; form-action 'none'"
    )


@cache
def _part(name: str) -> str:
    return (files("app.page") / _BUNDLE / name).read_text(encoding="utf-8")


@cache
def _hash(text: str) -> str:
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
