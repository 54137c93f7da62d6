"""Pictures of instances, cut out of the recording by one thread at a time."""

from __future__ import annotations

import threading
from pathlib import Path

from app.query.view_crops import ViewCrops, read_crop
from app.settings.run_config import InputSettings
from razer.map_object import MapObject


class CropPictures:
    """The crops of a run; the recording is opened when the first one is asked for."""

    def __init__(self, run: Path, settings: InputSettings) -> None:
        self._run, self._settings = run, settings
        self._lock = threading.Lock()
        self._crops: ViewCrops | None = None

    def _opened(self) -> ViewCrops:
        if self._crops is None:
            self._crops = ViewCrops(self._run, self._settings)
        return self._crops

    def count(self, instance: MapObject) -> int:
        """How many pictures of an instance there are."""
        with self._lock:
            return self._opened().count(instance)

    def picture(self, instance: MapObject, number: int) -> bytes | None:
        """A picture as JPEG, None where there is none of that number."""
        with self._lock:
            paths = [entry["crop"] for entry in self._opened().of(instance) if entry["crop"] is not None]
        return read_crop(Path(paths[number])) if number < len(paths) else None


class NoPictures(CropPictures):
    """A map without a recording at hand."""

    def __init__(self) -> None:
        super().__init__(Path(), InputSettings())

    def count(self, instance: MapObject) -> int:
        """None."""
        return 0

    def picture(self, instance: MapObject, number: int) -> bytes | None:
        """None."""
        return None
