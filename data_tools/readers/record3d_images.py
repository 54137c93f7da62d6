"""Images of Record3D's exports: JPEG colour; depth as lzfse-compressed float32, as EXR or as 16-bit PNG."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.images import MAX_FRAME_BYTES, decode_rgb, read_depth, read_rgb, short_name
from data_tools.recordings.recorded_sequence import ImageSource
from razer.arrays import Float32Array, Uint8Array
from razer.errors import BadInput, UnusableFrame
from razer.files import Archive, MissingFile, MissingMember, read_bytes

_MILLIMETRES = 1000.0
_HOW_TO_INSTALL = "pip install 'razer[record3d]'"
# The lidar's depth is 256x192; the selfie camera's 640x480. Either may be upright or lying.
_USUAL_SIZES = ((192, 256), (256, 192), (480, 640), (640, 480))


@lru_cache(maxsize=4)
def opened(path: Path) -> Archive:
    """An archive, kept open: reading its list anew for each frame would take longer than the frame. Raises BadInput."""
    return Archive(path)


@dataclass(frozen=True, slots=True)
class ArchiveImages(ImageSource):
    """rgbd/0.jpg, .depth and .conf of a .r3d archive or of its unpacked folder; depth_size 0, 0 = not known."""

    path: Path
    numbers: tuple[int, ...]
    stamps: tuple[float, ...]
    depth_size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.numbers)

    def require_packages(self) -> None:
        """Raise BadInput if what depth is compressed with is not installed."""
        _package("liblzfse", "pyliblzfse", self.path)

    def stamp(self, index: int) -> float:
        """Seconds."""
        return self.stamps[index]

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""
        name = f"rgbd/{self.numbers[index]}.jpg"
        return decode_rgb(self._read(name), name)

    def color_file(self, index: int) -> str:
        """The colour image's name in the archive."""
        return f"rgbd/{self.numbers[index]}.jpg"

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading or one of low confidence; raises UnusableFrame."""
        name = f"rgbd/{self.numbers[index]}.depth"
        values = np.frombuffer(self._decompressed(name), np.float32)
        width, height = self._size_of(values.size, name)
        depth = _finite(values.reshape(height, width))
        confidence = f"rgbd/{self.numbers[index]}.conf"
        if self._has(confidence):
            levels = np.frombuffer(self._decompressed(confidence), np.uint8)
            if levels.size == depth.size:
                depth[levels.reshape(depth.shape) == 0] = 0
        return depth

    def _size_of(self, count: int, name: str) -> tuple[int, int]:
        sizes = [self.depth_size] if all(self.depth_size) else []
        for width, height in [*sizes, *_USUAL_SIZES]:
            if width * height == count:
                return width, height
        raise UnusableFrame(f"{name} has {count} depths, not {self.depth_size[0]}x{self.depth_size[1]}")

    def _decompressed(self, name: str) -> bytes:
        lzfse = _package("liblzfse", "pyliblzfse", self.path)
        try:
            data: bytes = lzfse.decompress(self._read(name))
        except (lzfse.error, MemoryError) as error:  # the latter where the end is missing
            raise UnusableFrame(f"{name} is damaged or truncated") from error
        if len(data) % 4 and name.endswith(".depth"):
            raise UnusableFrame(f"{name} is damaged or truncated")
        return data

    def _has(self, name: str) -> bool:
        return name in opened(self.path) if self.path.is_file() else (self.path / name).is_file()

    def _read(self, name: str) -> bytes:
        try:
            return (
                opened(self.path).read(name) if self.path.is_file() else read_bytes(self.path / name, MAX_FRAME_BYTES)
            )
        except (MissingMember, MissingFile):
            raise UnusableFrame(f"{name} is missing") from None
        except BadInput as error:
            raise UnusableFrame(f"{name} cannot be read: {error}") from None


@dataclass(frozen=True, slots=True)
class FolderImages(ImageSource):
    """rgb/0.jpg (or .png) and depth/0.exr (metres) or .png (millimetres) of an EXR + JPG export."""

    path: Path
    numbers: tuple[int, ...]
    stamps: tuple[float, ...]
    depth_size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.numbers)

    def require_packages(self) -> None:
        """Raise BadInput if there are EXR images and what reads them is not installed."""
        if any((self.path / "depth").glob("*.exr")):
            _package("OpenEXR", "OpenEXR", self.path)

    def stamp(self, index: int) -> float:
        """Seconds."""
        return self.stamps[index]

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""
        return read_rgb(self._file("rgb", index, (".jpg", ".png", ".jpeg")))

    def color_file(self, index: int) -> str:
        """The path of the colour image."""
        return self._file("rgb", index, (".jpg", ".png", ".jpeg")).as_posix()

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading; raises UnusableFrame."""
        path = self._file("depth", index, (".exr", ".png"))
        return read_depth(path, _MILLIMETRES) if path.suffix == ".png" else _read_exr(path)

    def _file(self, part: str, index: int, suffixes: tuple[str, ...]) -> Path:
        stem = self.path / part / str(self.numbers[index])
        existing = (path for suffix in suffixes if (path := stem.with_suffix(suffix)).is_file())
        return next(existing, stem.with_suffix(suffixes[0]))


def _read_exr(path: Path) -> Float32Array:
    if not path.is_file():
        raise UnusableFrame(f"{short_name(path)} is missing")
    exr = _package("OpenEXR", "OpenEXR", path)
    try:
        with exr.File(str(path), separate_channels=True) as file:
            channels = file.channels()
            name = next((name for name in ("R", "Y", "Z") if name in channels), next(iter(channels)))
            return _finite(channels[name].pixels)
    except (RuntimeError, ValueError) as error:  # what the package raises for a damaged file
        raise UnusableFrame(f"{short_name(path)} is damaged or truncated") from error


def _finite(depth: NDArray) -> Float32Array:
    metres = depth.astype(np.float32)
    metres[~(np.isfinite(metres) & (metres > 0))] = 0
    return metres


def _package(module: str, package: str, path: Path) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise BadInput(f"{path} needs the package {package}: {_HOW_TO_INSTALL}") from None
