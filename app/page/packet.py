"""Container of the page's binary data: a JSON header and byte sections, gzipped, read again by viewer/src/packet.ts.

Numbers are kept as byte planes, all low bytes first: DEFLATE then sees runs of like bytes. Layout before compression:
`RZPG`, the header's length as uint32, the header as UTF-8, the sections one after the other in the header's order.
"""

from __future__ import annotations

import gzip
import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"RZPG"
SMALLEST = 9


def pack(header: Mapping[str, Any], sections: Mapping[str, bytes], level: int = SMALLEST) -> bytes:
    """The container, gzipped at a level of zlib, without a time in it, so that the same map gives the same bytes."""
    table = [{"name": name, "bytes": len(content)} for name, content in sections.items()]
    text = json.dumps({**header, "sections": table}, separators=(",", ":"), ensure_ascii=False).encode()
    return gzip.compress(b"".join([MAGIC, struct.pack("<I", len(text)), text, *sections.values()]), level, mtime=0)


def unpack(packed: bytes) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Header and sections again; raises ValueError for anything else."""
    data = gzip.decompress(packed)
    if data[:4] != MAGIC:
        raise ValueError("no page data")
    start = 8 + struct.unpack_from("<I", data, 4)[0]
    header = json.loads(data[8:start])
    sections = {}
    for entry in header.pop("sections"):
        sections[entry["name"]] = data[start : start + entry["bytes"]]
        start += entry["bytes"]
    return header, sections


def planes(numbers: NDArray, n_planes: int) -> bytes:
    """Whole numbers (N,) >= 0 as `n_planes` planes of N bytes, low bytes first."""
    words = np.ascontiguousarray(numbers, dtype="<u4")
    return np.ascontiguousarray(words.view(np.uint8).reshape(-1, 4)[:, :n_planes].T).tobytes()


def zigzag(differences: NDArray) -> NDArray:
    """Signed numbers (N,) as numbers >= 0: 0, -1, 1, -2, 2 become 0, 1, 2, 3, 4."""
    signed = differences.astype(np.int64)
    return (signed << 1) ^ (signed >> 63)
