"""NumPy's files within bounds: an array is as large as the file says only where the file holds as much.

Arrays of Python objects are never read, as that would run what the file says.
"""

from __future__ import annotations

import math
import sys
import tokenize
from collections.abc import Iterable
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from razer.errors import BadInput, one_line
from razer.files.archives import Archive
from razer.files.file_bytes import opened

_PIECE_BYTES = 2**20
_SURROGATES = (0xD800, 0xE000)  # halves of characters
_MALFORMED = (ValueError, TypeError, KeyError, SyntaxError, EOFError, RecursionError, MemoryError, tokenize.TokenError)


def read_npy(path: Path) -> NDArray:
    """The array in a .npy file; raises BadInput."""
    with opened(path) as file:
        size = file.seek(0, 2)
        file.seek(0)
        return _array(file, size, str(path))


def read_npz(path: Path, names: Iterable[str] | None = None) -> dict[str, NDArray]:
    """The arrays of a .npz file by name; names: those that are needed, None = all. Raises BadInput, also where one is
    missing."""
    with Archive(path) as archive:
        if names is None:
            names = [name.removesuffix(".npy") for name in archive.names if name.endswith(".npy")]
        return {name: _member(archive, f"{name}.npy") for name in names}


def _member(archive: Archive, name: str) -> NDArray:
    size = archive.size(name)
    with archive.opened(name) as member:
        return _array(member, size, f"{archive.path}, member {name}")


def _array(file: IO[bytes], size: int, name: str) -> NDArray:
    """The array in a stream of so many bytes."""
    try:
        version = np.lib.format.read_magic(file)
        readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
        shape, in_fortran_order, dtype = readers[version](file)
        if dtype.hasobject:
            raise BadInput(f"{name} holds Python objects, which are never read: save plain numbers or texts")
        n_values = math.prod(shape)
        if any(side < 0 for side in shape) or n_values * dtype.itemsize != size - file.tell():
            raise BadInput(f"{name} is cut short, or says that it holds {n_values} of {dtype}: make it again")
        values = np.empty(n_values, dtype)
    except BadInput:
        raise
    except _MALFORMED as error:
        raise BadInput(f"{name} is no array of NumPy, or a damaged one ({one_line(error)}): make it again") from None
    _fill(values, file, name)
    if dtype.kind == "U":
        _require_characters(values, name)
    return values.reshape(shape[::-1]).T if in_fortran_order else values.reshape(shape)


def _require_characters(texts: NDArray, name: str) -> None:
    """Raise BadInput for texts with what is no character, of which NumPy would make texts that Python cannot handle."""
    codes = texts.view(f"{texts.dtype.str[0]}u4") if texts.nbytes else np.zeros(0, np.uint32)
    is_half = (codes >= _SURROGATES[0]) & (codes < _SURROGATES[1])
    if (codes > sys.maxunicode).any() or is_half.any():
        raise BadInput(f"{name} has texts with what is no character: make it again")


def _fill(values: NDArray, file: IO[bytes], name: str) -> None:
    target = values.view(np.uint8) if values.nbytes else np.empty(0, np.uint8)
    at = 0
    while at < len(target):
        piece = file.read(min(_PIECE_BYTES, len(target) - at))
        if not piece:
            raise BadInput(f"{name} is cut short: make it again")
        target[at : at + len(piece)] = np.frombuffer(piece, np.uint8)
        at += len(piece)
    file.read(1)  # at its end an archive compares what it read with the checksum
