"""A Rerun recording, read back."""

from __future__ import annotations

from pathlib import Path

import rerun as rr


def chunks_of(path: Path) -> dict[str, list[dict]]:
    """All rows of a recording by entity path, each with its frame and its components' short names."""
    rows: dict[str, list[dict]] = {}
    for chunk in rr.chunk.RrdReader(path).stream().to_chunks():
        for row in chunk.to_record_batch().to_pylist():
            named = {key.split(":")[-1]: value for key, value in row.items() if value is not None}
            rows.setdefault(chunk.entity_path.lstrip("/"), []).append(named)
    return {entity: sorted(found, key=lambda r: r.get("frame", -1)) for entity, found in rows.items()}
