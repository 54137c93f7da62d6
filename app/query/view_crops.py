"""Crops of the best views of an instance, cut out of the recording where it is still there."""

from __future__ import annotations

from contextlib import suppress
from errno import ELOOP
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from app.settings.run_config import InputSettings
from razer.arrays import BoolArray, Uint8Array
from razer.detection.best_views import BestView
from razer.errors import BadInput, UntrustedPlugin, UnusableFrame
from razer.files import image_size, read_bytes
from razer.frame import Frame, RecordedColor
from razer.map_object import MapObject
from razer.storage.atomic_files import replace_content

if TYPE_CHECKING:
    from data_tools.recordings.color_warp import ColorWarp
    from data_tools.recordings.sequence import RgbdSequence

CROPS = "crops"
MAX_CROP_BYTES = 64 * 2**20
Box = tuple[int, int, int, int]  # x, y, width, height, pixels
_MARGIN = 0.15  # of the box on each side: context helps to recognise an object


class ViewCrops:
    """Crops of a run's recording, kept in the run folder; `notes`: which are missing and why.

    Args:
        run: the folder.
        settings: of the run; they say where its recording lies.
        recording: where that is no folder.
    """

    def __init__(self, run: Path, settings: InputSettings, recording: RgbdSequence | None = None) -> None:
        self.notes: list[str] = []
        self._run, self._settings, self._recording = run, settings, recording
        self._color_warp: ColorWarp | None = None

    def count(self, instance: MapObject) -> int:
        """How many of an instance's views have a picture: all while the recording is there, else those cut before."""
        if self._sequence is not None:
            return len(instance.views)
        return sum(_is_crop(self._path(instance.id, view)) for view in instance.views)

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
        from app.frames.cameras.run_registration import registration_of_run
        from app.frames.open_recording import open_unchecked  # late, as most of its readers will not be needed

        if self._recording is not None:
            return self._recording
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
            self.notes.append(f"no crops but those that are there: {error}")
            return None

    def _path(self, instance_id: int, view: BestView) -> Path:
        return self._run / CROPS / f"{instance_id:04d}-{view.frame:06d}.jpg"

    def _crop(self, instance_id: int, view: BestView) -> str | None:
        path = self._path(instance_id, view)
        if _is_crop(path):
            return str(path)
        if self._sequence is None:
            return None
        try:
            frame = self._sequence[view.frame]
            if self._color_warp is not None:
                frame = self._color_warp.registered(frame)
            crop = cv2.cvtColor(crop_of(frame, view.region.box), cv2.COLOR_RGB2BGR)
            _keep(path, cv2.imencode(".jpg", crop)[1].tobytes())
        except (UnusableFrame, IndexError, OSError, cv2.error) as error:
            self.notes.append(f"no crop of frame {view.frame}: {error}")
            return None
        return str(path)


def read_crop(path: Path) -> bytes:
    """The JPEG file of a crop; raises BadInput for anything else that lies in its place."""
    data = read_bytes(path, MAX_CROP_BYTES)
    image_size(data, str(path))
    return data


def _is_crop(path: Path) -> bool:
    """Whether a crop lies there; what a link leads to may be any file of who looks at a run of somebody else's."""
    return path.is_file() and not path.is_symlink() and not path.parent.is_symlink()


def _keep(path: Path, jpeg: bytes) -> None:
    """Keep a crop; raises OSError, also where the folder of the crops is a link: they would be written elsewhere."""
    if path.parent.is_symlink():
        raise OSError(ELOOP, "it is a link", str(path.parent))
    path.parent.mkdir(exist_ok=True)
    try:
        replace_content(path, jpeg)
    except OSError:
        with suppress(OSError):  # others are in it
            path.parent.rmdir()
        raise


def crop_of(frame: Frame, box: Box) -> Uint8Array:
    """The part (h, w, 3) of a frame's picture that a box covers, with a margin; of the picture as it was recorded where
    there is another, which is torn nowhere."""
    recorded = frame.recorded_color
    rgb = frame.rgb if recorded is None else recorded.rgb
    rows, columns = _ranges(box if recorded is None else _box_in(recorded, box, frame.has_color), rgb.shape)
    return np.ascontiguousarray(rgb[rows, columns])


def _box_in(recorded: RecordedColor, box: Box, has_color: BoolArray | None) -> Box:
    """A box of the depth image in the recorded picture; as it is where the colour camera sees nothing of it."""
    x, y, width, height = box
    inside = slice(y, y + height), slice(x, x + width)
    pixels = recorded.pixel[inside] if has_color is None else recorded.pixel[inside][has_color[inside]]
    if not pixels.size:
        return box
    rows, columns = np.divmod(pixels.ravel(), recorded.rgb.shape[1])
    left, top = int(columns.min()), int(rows.min())
    return left, top, int(columns.max()) - left + 1, int(rows.max()) - top + 1


def _ranges(box: Box, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The rows and columns of a box with its margin in an image of that shape."""
    x, y, width, height = box
    ranges = []
    for start, length, size in ((y, height, shape[0]), (x, width, shape[1])):
        margin = round(_MARGIN * length)
        ranges.append(slice(max(0, start - margin), min(size, start + length + margin)))
    return ranges[0], ranges[1]
