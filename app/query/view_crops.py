"""The frames that show an instance best, cut out of the recording where it is still there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from app.frames.open_recording import open_unchecked
from app.settings.run_config import InputSettings
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Uint8Array
from razer.detection.best_views import BestView
from razer.errors import BadInput, UnusableFrame
from razer.map_object import MapObject

CROPS = "crops"
_MARGIN = 0.15  # of the box on each side: a thing is recognised by what is round it


class BestFrames:
    """Crops of a run's recording in its folder; notes, what is missing and why."""

    def __init__(self, run: Path, settings: InputSettings) -> None:
        self.notes: list[str] = []
        self._folder = run / CROPS
        self._sequence = self._open(settings)

    def of(self, item: MapObject) -> list[dict[str, Any]]:
        """frame, stamp (seconds), box [x, y, width, height] and crop, the path of a picture or None, the best first."""
        return [
            {"frame": view.frame, "stamp": view.stamp, "box": list(view.region.box), "crop": self._crop(item.id, view)}
            for view in item.views
        ]

    def _open(self, settings: InputSettings) -> RgbdSequence | None:
        try:
            if settings.folder is None:
                raise BadInput("the run does not say where its recording lies")
            if not Path(settings.folder).exists():
                raise BadInput(f"the recording {settings.folder} is not there any more")
            return open_unchecked(Path(settings.folder), settings)
        except BadInput as error:
            self.notes.append(f"no crops: {error}")
            return None

    def _crop(self, instance: int, view: BestView) -> str | None:
        path = self._folder / f"{instance:04d}-{view.frame:06d}.jpg"
        if path.is_file():
            return str(path)
        if self._sequence is None:
            return None
        try:
            frame = self._sequence[view.frame]
            self._folder.mkdir(exist_ok=True)
            part = path.with_name(f".part-{path.name}")
            cv2.imwrite(str(part), cv2.cvtColor(cut_out(frame.rgb, view), cv2.COLOR_RGB2BGR))
            os.replace(part, path)
        except (UnusableFrame, IndexError, OSError, cv2.error) as error:
            self.notes.append(f"no crop of frame {view.frame}: {error}")
            return None
        return str(path)


def cut_out(rgb: Uint8Array, view: BestView) -> Uint8Array:
    """The part (h, w, 3) of an image that a view's box covers, with a margin."""
    (left, right), (top, bottom) = _ranges(view, rgb.shape)
    return np.ascontiguousarray(rgb[top:bottom, left:right])


def _ranges(view: BestView, shape: tuple[int, ...]) -> Iterator[tuple[int, int]]:
    x, y, width, height = view.region.box
    for start, length, size in ((x, width, shape[1]), (y, height, shape[0])):
        margin = round(_MARGIN * length)
        yield max(0, start - margin), min(size, start + length + margin)
