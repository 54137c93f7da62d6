"""A folder or file that is named by a path or by a URI."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from app.settings.extra_libraries import require_s3
from razer.errors import BadInput

TRIED = ("s3", "file")
# Throttling and answers 5xx are tried again by botocore, which slows down as the store asks.
_OPTIONS = {"s3": {"config_kwargs": {"retries": {"mode": "adaptive", "max_attempts": 8}}}}


@dataclass(frozen=True)
class Place:
    """text: an absolute path, or a URI, without a slash at its end."""

    text: str

    @classmethod
    def of(cls, text: str) -> Place:
        """The place that a user names; raises BadInput for an empty text, as of a variable that is not set, for a URI
        without a bucket, or with a password in it, and where there is no library for it."""
        if not text.strip():
            raise BadInput("an empty text names no place: give a folder or a URI")
        if "://" not in text:
            return cls(os.path.abspath(text))
        parts = urlsplit(text)
        if parts.scheme == "file":
            return cls(os.path.abspath(unquote(parts.path)))
        refuse_keys(text, with_query=True)
        if not parts.netloc:
            raise BadInput(f"{text} names no bucket: write it as {parts.scheme}://BUCKET/PATH")
        _require_library(parts.scheme)
        return cls(text.rstrip("/"))

    @property
    def is_remote(self) -> bool:
        """Whether it lies in a store, not in a folder of this machine."""
        return "://" in self.text

    @property
    def is_tried(self) -> bool:
        """Whether stores of its kind are tested."""
        return not self.is_remote or urlsplit(self.text).scheme in TRIED

    @property
    def path(self) -> Path:
        """Of one on this machine."""
        assert not self.is_remote
        return Path(self.text)

    @property
    def name(self) -> str:
        """What follows the last slash."""
        return self.text.rpartition("/")[2]

    def __truediv__(self, name: str) -> Place:
        return Place(f"{self.text.rstrip('/')}/{name}")

    def __str__(self) -> str:
        return self.text

    def opened(self) -> tuple[Any, str]:
        """The store, as fsspec has it, and what it calls the place; raises BadInput where it cannot be opened."""
        from fsspec.core import url_to_fs

        scheme = urlsplit(self.text).scheme
        try:
            return url_to_fs(self.text, **_OPTIONS.get(scheme, {}))
        except (ImportError, ValueError) as error:
            raise BadInput(f"{self.text}: {error}") from error


def refuse_keys(uri: str, *, with_query: bool) -> None:
    """Raise BadInput, which does not repeat them, for a URI with a user, a password or, as some have keys there, with a
    query."""
    parts = urlsplit(uri)
    if parts.username is not None or parts.password is not None or (with_query and parts.query):
        where = f"{parts.scheme}://{parts.hostname or ''}{parts.path}"
        raise BadInput(f"{where}: leave user, password and keys out of it; they come from the environment")


def _require_library(scheme: str) -> None:
    from fsspec.registry import known_implementations

    if scheme in ("s3", "s3a"):
        require_s3()
    known = known_implementations.get(scheme)
    if known is None:
        raise BadInput(f"{scheme}:// is no store that fsspec knows: give a path, file:// or s3://")
    library = known["class"].partition(".")[0]
    if find_spec(library) is None:
        raise BadInput(f"{scheme}:// needs another library: {known.get('err', f'pip install {library}')}")
