"""Mask files of the ScanNet benchmark: one number a line for each vertex, not 0 on the vertices of the mask."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from razer.arrays import BoolArray
from razer.errors import BadInput
from razer.files import MAX_TEXT_BYTES, MissingFile, read_bytes

_NEWLINE, _ZERO, _NINE = b"\n09"
_SPACES = np.frombuffer(b" \t\n", np.uint8)


def read_mask(path: Path) -> BoolArray:
    """The mask (V,) in a file; raises BadInput naming it. Lines of one digit, as nearly all such files have, and other
    whole numbers are looked at as bytes; all else is parsed number by number."""
    try:
        data = read_bytes(path, MAX_TEXT_BYTES)
    except MissingFile:
        raise BadInput(f"{path} is missing: a submission needs the mask files that its list names") from None
    text = data.replace(b"\r", b"").rstrip()
    mask = _single_digits(text)
    mask = _whole_numbers(text) if mask is None else mask
    try:
        return np.array(data.split(), np.float64) != 0 if mask is None else mask
    except ValueError:
        raise BadInput(f"{path} must hold one number a line, not 0 for vertices of the mask") from None


def mask_text(mask: BoolArray) -> bytes:
    """The content of the file that holds a mask (V,)."""
    lines = np.full((len(mask), 2), _NEWLINE, np.uint8)
    lines[:, 0] = _ZERO + mask
    return lines.tobytes()


def _single_digits(text: bytes) -> BoolArray | None:
    """The mask of a text whose lines are single digits, without the end of the last; None for any other."""
    characters = np.frombuffer(text, np.uint8)
    digits, ends = characters[::2], characters[1::2]
    if len(characters) % 2 == 0 or (ends != _NEWLINE).any() or ((digits < _ZERO) | (digits > _NINE)).any():
        return None
    return digits != _ZERO


def _whole_numbers(text: bytes) -> BoolArray | None:
    """The mask of a text of digits and white space: where a number has a digit that is not 0; None for any other."""
    characters = np.frombuffer(text, np.uint8)
    is_digit = (characters >= _ZERO) & (characters <= _NINE)
    is_space = np.isin(characters, _SPACES)
    begins = is_digit & np.concatenate([np.ones(1, np.bool_), is_space[:-1]])[: len(characters)]
    if not begins.any() or not (is_digit | is_space).all():
        return None
    return np.logical_or.reduceat(is_digit & (characters > _ZERO), np.flatnonzero(begins))
