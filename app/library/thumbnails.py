"""Thumbnails of instances: their best views, small, kept in a table beside that of the instances."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import cv2
import pyarrow as pa

from app.console.streams import print_notes
from app.library.tables.lance_tables import LancePlace, LanceTable, plain_errors, quoted
from app.query.view_crops import ViewCrops, read_crop
from app.settings.run_config import InputSettings
from razer.errors import BadInput
from razer.files import decode_image
from razer.panoptic_map import PanopticMap

TABLE = "thumbnails"
_SIDE, _QUALITY = 128, 80  # pixels of the longer side; of the JPEG
_SCHEMA = pa.schema([("run", pa.string()), ("generation", pa.int64()), ("id", pa.int32()), ("jpeg", pa.binary())])


def thumbnails_of(folder: Path, panoptic: PanopticMap, settings: InputSettings) -> dict[int, bytes]:
    """JPEGs of the best views of a run's instances and parts, as far as its recording or its crops are there, by id."""
    crops, pictures = ViewCrops(folder, settings), {}
    for item in sorted((*panoptic.objects, *panoptic.parts), key=lambda item: item.views[0].frame if item.views else 0):
        for view in crops.of(replace(item, views=item.views[:1])):
            if view["crop"] is not None:
                with suppress(BadInput):
                    pictures[item.id] = _small(read_crop(Path(view["crop"])))
    print_notes(crops.notes[:1])
    return pictures


def keep_thumbnails(uri: str, run: str, generation: int, pictures: Mapping[int, bytes]) -> None:
    """Write the thumbnails of a map; those of what it was before stay until `forget_thumbnails`. Raises BadInput."""
    if not pictures:
        return
    columns = ([run] * len(pictures), [generation] * len(pictures), list(pictures), list(pictures.values()))
    rows = pa.table([pa.array(each, field.type) for each, field in zip(columns, _SCHEMA, strict=True)], schema=_SCHEMA)
    with plain_errors(f"{uri}: thumbnails cannot be kept"):
        LancePlace(uri).made(TABLE, _SCHEMA).append(rows, generation)


def forget_thumbnails(uri: str, run: str, before: int | None = None) -> None:
    """Remove the thumbnails of a map, or those of generations before one. Raises BadInput."""
    table = _table(uri)
    where = f"run = {quoted(run)}" + ("" if before is None else f" AND generation < {before}")
    with plain_errors(f"{uri}: thumbnails cannot be removed"):
        if table is not None and table.count(where):
            table.delete(where)


def thumbnail(uri: str, run: str, instance_id: int) -> bytes | None:
    """The newest thumbnail of an instance; None where there is none. Raises BadInput."""
    if (table := _table(uri)) is None:
        return None
    with plain_errors(f"{uri} cannot be read"):
        rows = table.rows(f"run = {quoted(run)} AND id = {instance_id}", ("generation", "jpeg")).to_pylist()
    return max(rows, key=lambda row: row["generation"])["jpeg"] if rows else None


def _table(uri: str) -> LanceTable | None:
    place = LancePlace(uri)
    return place.table(TABLE) if TABLE in place.names else None


def _small(jpeg: bytes) -> bytes:
    picture = decode_image(jpeg, "a crop", cv2.IMREAD_COLOR)
    scale = min(1.0, _SIDE / max(picture.shape[:2]))
    size = [max(1, round(scale * side)) for side in picture.shape[1::-1]]
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1].tobytes()
