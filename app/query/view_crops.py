"""Crops of the best views of an instance, cut out of the recording where it is still there."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from app.settings.run_config import InputSettings
from razer.arrays import Uint8Array
from razer.detection.best_views import BestView
from razer.errors import BadInput, UntrustedPlugin, UnusableFrame
from razer.map_object import MapObject
from razer.storage.atomic_files import replace_file

if TYPE_CHECKING:
    from data_tools.recordings.color_warp import ColorWarp
    from data_tools.recordings.sequence import RgbdSequence

CROPS = "crops"
_MARGIN = 0.15  # of the box on each side: context helps to recognise an object


class ViewCrops:
    """Crops of a run's recording, kept in the run folder; `notes`: which are missing and why."""

    def __init__(self, run: Path, settings: InputSettings) -> None:
        self.notes: list[str] = []
        self._run, self._settings = run, settings
        self._color_warp: ColorWarp | None = None

    def count(self, instance: MapObject) -> int:
        """How many of an instance's views have a picture: all while the recording is there, else those cut before."""
        if self._sequence is not None:
            return len(instance.views)
        return sum(self._path(instance.id, view).is_file() for view in instance.views)

    def of(self, instance: MapObject) -> list[dict[str, Any]]:
        """frame, stamp (seconds), box [x, y, width, height] and crop, the path of a picture or None, the best first."""
        return [
            {
                "frame": view.frame,
                "stamp": view.stamp,
                "box": list(view.region.box),
                "crop": self._crop(instance.id, view),
            }
            for view in instance.views
        ]

    @cached_property
    def _sequence(self) -> RgbdSequence | None:
        """The recording, opened for the first crop that is not there yet; None where that cannot be."""
        from app.frames.open_recording import open_unchecked  # late, as most of its readers will not be needed
        from app.frames.run_registration import registration_of_run

        settings = self._settings
        try:
            if settings.folder is None:
                raise BadInput("the run does not say where its recording lies")
            if not Path(settings.folder).exists():
                raise BadInput(f"the recording {settings.folder} is not there any more")
            sequence = open_unchecked(Path(settings.folder), settings)
            self._color_warp = registration_of_run(self._run, sequence.intrinsics)
            return sequence
        except UntrustedPlugin:
            raise
        except (BadInput, OSError) as error:
            self.notes.append(f"no crops: {error}")
            return None

    def _path(self, instance_id: int, view: BestView) -> Path:
        return self._run / CROPS / f"{instance_id:04d}-{view.frame:06d}.jpg"

    def _crop(self, instance_id: int, view: BestView) -> str | None:
        path = self._path(instance_id, view)
        if path.is_file():
            return str(path)
        if self._sequence is None:
            return None
        try:
            frame = self._sequence[view.frame]
            if self._color_warp is not None:
                frame = self._color_warp.registered(frame)
            path.parent.mkdir(exist_ok=True)
            crop = cv2.cvtColor(crop_view(frame.rgb, view), cv2.COLOR_RGB2BGR)
            replace_file(path, lambda part: cv2.imwrite(str(part), crop))
        except (UnusableFrame, IndexError, OSError, cv2.error) as error:
            self.notes.append(f"no crop of frame {view.frame}: {error}")
            return None
        return str(path)


def crop_view(rgb: Uint8Array, view: BestView) -> Uint8Array:
    """The part (h, w, 3) of an image that a view's box covers, with a margin."""
    (left, right), (top, bottom) = _ranges(view, rgb.shape)
    return np.ascontiguousarray(rgb[top:bottom, left:right])


def _ranges(view: BestView, shape: tuple[int, ...]) -> Iterator[tuple[int, int]]:
    x, y, width, height = view.region.box
    for start, length, size in ((x, width, shape[1]), (y, height, shape[0])):
        margin = round(_MARGIN * length)
        yield max(0, start - margin), min(size, start + length + margin)
