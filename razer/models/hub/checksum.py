"""Checksums of downloaded files: SHA-256, or git's object id for small files."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

_SHA256 = re.compile(r"[0-9a-f]{64}")
_GIT_ID = re.compile(r"[0-9a-f]{40}")
_CHUNK = 1 << 20


def checksum_kind(published: str) -> str:
    """What a published checksum is: "sha256" for large files, "git id" for small ones, "" if it is no checksum of
    the content."""
    if _SHA256.fullmatch(published):
        return "sha256"
    return "git id" if _GIT_ID.fullmatch(published) else ""


def checksum(path: Path, kind: str) -> str:
    """The checksum of a file as lower-case hexadecimal; kind as `checksum_kind` says."""
    digest = hashlib.sha256() if kind == "sha256" else hashlib.sha1(b"blob %d\0" % path.stat().st_size)
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()
