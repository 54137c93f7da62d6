"""Pictures as files: where a user wants one, and beside the results of a verb."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from rich.console import Console

from app.console.streams import print_notes
from app.pictures.map_picture import Scene, draw
from app.pictures.view import View
from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.storage.atomic_files import replace_file

_COMPRESSION = 7  # of PNG, 0 to 9: the last steps take seconds for a hundredth
_OPAQUE = (".jpg", ".jpeg", ".bmp")


def check_picture_path(path: Path, view: View | None = None) -> None:
    """Raise BadInput, before any work is done, where a picture cannot be written."""
    if not path.absolute().parent.is_dir() or not cv2.haveImageWriter(str(path)):
        raise BadInput(f"{path} cannot be written: give a .png in a folder that exists")
    if view is not None and view.background == "transparent" and path.suffix.lower() in _OPAQUE:
        raise BadInput(f"{path} cannot be transparent: give a .png")
    if path.is_dir():
        raise BadInput(f"{path} is a folder: give a .png in it")


def write_picture(path: Path, pixels: Uint8Array) -> None:
    """Write RGB pixels (H, W, 3), or with opacity (H, W, 4); raises OSError."""

    def write(part: Path) -> None:
        order = cv2.COLOR_RGB2BGR if pixels.shape[2] == 3 else cv2.COLOR_RGBA2BGRA
        image = cv2.cvtColor(np.ascontiguousarray(pixels), order)
        done, content = cv2.imencode(path.suffix, image, [cv2.IMWRITE_PNG_COMPRESSION, _COMPRESSION])
        if not done:
            raise OSError(f"no {path.suffix} can be made of this picture")
        part.write_bytes(content.tobytes())

    replace_file(path, write)


def write_view(path: Path, scene: Scene, view: View, console: Console) -> None:
    """Draw a scene where the user wants it and say from which angle; raises BadInput where it cannot be written."""
    check_picture_path(path, view)
    picture = draw(scene, view)
    try:
        write_picture(path, picture.pixels)
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror})") from error
    console.print(f"picture: {path} (--angle {picture.angle})", soft_wrap=True)


def add_picture(path: Path, scene: Scene, console: Console, view: View | None = None) -> None:
    """Draw a scene beside the results of a verb and say where it is; a folder that is read-only is no error."""
    try:
        write_picture(path, draw(scene, view or View()).pixels)
    except OSError as error:
        print_notes([f"{path} cannot be written ({error.strerror}): no picture"])
        return
    console.print(f"picture: {path}", soft_wrap=True)
