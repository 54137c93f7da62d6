"""Small pictures of instances for the page, of the crops that a run keeps or that its recording still gives."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import cv2

from app.query.view_crops import ViewCrops, read_crop
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.files import decode_image
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap

LONGEST_PX = 208
QUALITY = 74
MAX_PICTURES = 320  # some 6 KB each


def crop_pictures(run: Path, config: RunConfig, panoptic: PanopticMap) -> dict[int, list[bytes]]:
    """JPEG files by instance, the best view first; fewer of each where there are many instances, none where neither
    crops nor recording are at hand."""
    try:
        crops = ViewCrops(run, config.input)
    except BadInput:  # a reader of one's own that nobody trusted here
        return {}
    shown = sorted([*panoptic.objects, *panoptic.parts], key=lambda item: item.id)
    each = max(1, min(3, MAX_PICTURES // max(len(shown), 1)))
    pictures = {item.id: _pictures(crops, item, each) for item in shown[:MAX_PICTURES]}
    return {i: files for i, files in pictures.items() if files}


def _pictures(crops: ViewCrops, item: MapObject, n: int) -> list[bytes]:
    files = []
    for view in crops.of(item)[:n]:
        if view["crop"] is not None:
            with suppress(BadInput):  # what lies there is no picture
                image = decode_image(read_crop(Path(view["crop"])), view["crop"], cv2.IMREAD_COLOR)
                files.append(_small_jpeg(image))
    return files


def _small_jpeg(image: cv2.typing.MatLike) -> bytes:
    scale = LONGEST_PX / max(image.shape[:2])
    if scale < 1:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
