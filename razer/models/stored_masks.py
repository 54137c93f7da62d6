"""Precomputed masks, read from files that another program wrote."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import IntArray
from razer.errors import BadInput, UnusableFrame
from razer.files import decode_image, read_bytes, read_npz
from razer.frame import Frame, Masks

_EXPECTED = "files are named by the number of the frame in six digits, 000007.png or 000007.npz"


class StoredMasks:
    """Masks from `folder`: for frame 7 either `000007.png`, 16 or 8 bit ids with 0 = unlabelled, or `000007.npz` with
    `ids` (H, W) or `masks` (N, H, W) bool and, if known, `scores` (N,) in [0, 1], `names` (N,) and `stuff` (N,)
    bool; for `ids`, N counts the positive ids in increasing order. A frame without a file has no masks.

    Raises BadInput for a missing folder, and for one without any file of such a name; `segment` raises UnusableFrame,
    naming the file, for one it cannot use.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder).expanduser()
        if not self.folder.is_dir():
            raise BadInput(f"no folder {self.folder}: set segmenter option folder to where the masks are")
        if not self._numbers():
            raise BadInput(f"{self.folder} has no masks: {_EXPECTED}, but {self._found()}")

    def count_frames(self, indices: Collection[int]) -> int:
        """How many of the frames have a file; raises BadInput naming the folder where none has."""
        numbers = self._numbers()
        matching = len(numbers.intersection(indices))
        if not matching:
            span = f"{min(indices, default=0)} to {max(indices, default=0)}"
            raise BadInput(
                f"{self.folder} has masks for none of the {len(indices)} frames, which are numbered {span}: "
                f"{_EXPECTED}, but {self._found()}"
            )
        return matching

    def _numbers(self) -> set[int]:
        """The frames that have a file."""
        return {int(path.stem) for path in self.folder.iterdir() if _is_named_as_frame(path)}

    def _found(self) -> str:
        names = sorted(path.name for path in self.folder.iterdir())
        return f"there are {names[0]} ... {names[-1]}" if names else "it is empty"

    def segment(self, frame: Frame) -> Masks:
        """The masks on file for frame.index; raises UnusableFrame."""
        shape = (frame.intrinsics.height, frame.intrinsics.width)
        stem = self.folder / f"{frame.index:06d}"
        if (image := stem.with_suffix(".png")).exists():
            return Masks.from_ids(_checked_size(_read_png(image), shape, image))
        if (archive := stem.with_suffix(".npz")).exists():
            return _read_npz(archive, shape)
        return Masks.none(*shape)


def _is_named_as_frame(path: Path) -> bool:
    stem = path.stem
    return path.suffix in (".png", ".npz") and stem.isdecimal() and stem == f"{int(stem):06d}"


def _read_png(file: Path) -> IntArray:
    try:
        ids = decode_image(read_bytes(file), str(file), cv2.IMREAD_UNCHANGED)
    except BadInput as error:
        raise UnusableFrame(str(error)) from None
    if ids.ndim != 2 or ids.dtype not in (np.uint8, np.uint16):
        raise UnusableFrame(f"{file} is not a grey image of 8 or 16 bits with one id a pixel")
    return ids.astype(np.int32)


def _read_npz(file: Path, shape: tuple[int, int]) -> Masks:
    try:
        arrays = read_npz(file)
    except BadInput as error:
        raise UnusableFrame(str(error)) from None
    if "masks" in arrays and arrays["masks"].ndim == 3:
        masks = Masks(arrays["masks"].astype(bool), np.ones(len(arrays["masks"]), np.float32))
    elif "ids" in arrays and arrays["ids"].ndim == 2 and np.issubdtype(arrays["ids"].dtype, np.integer):
        masks = Masks.from_ids(arrays["ids"])
    else:
        raise UnusableFrame(f"{file} holds neither ids (H, W), whole numbers, nor masks (N, H, W)")
    _checked_size(masks.masks, shape, file)
    return _described(masks, arrays, file)


def _checked_size(image: NDArray, shape: tuple[int, int], file: Path) -> NDArray:
    if image.shape[-2:] != shape:
        (height, width), (rows, columns) = shape, image.shape[-2:]
        raise UnusableFrame(f"{file} is {columns}x{rows} pixels, but the frame is {width}x{height}")
    return image


def _described(masks: Masks, arrays: dict[str, NDArray], file: Path) -> Masks:
    """The masks with the scores, names and flags of stuff in the file."""
    scores = np.asarray(arrays.get("scores", masks.scores))
    names, stuff = arrays.get("names"), arrays.get("stuff")
    if scores.dtype.kind not in "fiub" or scores.shape != (len(masks),) or not ((scores >= 0) & (scores <= 1)).all():
        raise UnusableFrame(f"{file} has {len(masks)} masks: scores must be as many numbers from 0 to 1")
    if names is not None and names.shape != (len(masks),):
        raise UnusableFrame(f"{file} has {len(masks)} masks but names of shape {names.shape}")
    if stuff is not None and (stuff.shape != (len(masks),) or not np.isin(stuff, (0, 1)).all()):
        raise UnusableFrame(f"{file} has {len(masks)} masks: stuff must say true or false of each")
    class_names = None if names is None else tuple(map(str, names))
    flags = None if stuff is None else stuff.astype(np.bool_)
    return Masks(masks.masks, scores.astype(np.float32), class_names, flags)
