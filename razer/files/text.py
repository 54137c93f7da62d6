"""Text, JSON and TOML within bounds on size, nesting and numbers."""

from __future__ import annotations

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from razer.arrays import Float64Array
from razer.errors import BadInput, one_line
from razer.files.file_bytes import read_bytes

# What reading values out of parsed content raises where it is of another form than expected.
MALFORMED = (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError)
MAX_TEXT_BYTES = 256 * 2**20  # the segments of a scan in full resolution have 20 MB
MAX_TOML_BYTES = 2**20
MAX_DEPTH = 64  # of sections, objects and lists in one another
MAX_DIGITS = 40  # of a whole number; tokenizers write 10^30 for no limit, and a float holds 10^308
# The time that tomllib takes for one key grows with the square of how many parts it has.
_MANY_PARTS = re.compile(rf"""(?:(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MAX_DEPTH}}}""")
_SURROGATES = re.compile(r"\\u[dD][89a-fA-F]")  # halves of characters, written as escapes
# What may be too large for a float, or a whole number that nothing holds; only then each number is looked at.
_LARGE_NUMBERS = re.compile(rf"\d{{{MAX_DIGITS + 1}}}|[eE]\+?\d{{3}}")


def read_text(path: Path, *, replace_errors: bool = False, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """The text of a file in UTF-8, with or without a mark at its beginning; raises BadInput naming the line where it is
    none. replace_errors: where single characters do not matter, what is no UTF-8 becomes U+FFFD."""
    return _decoded(read_bytes(path, max_bytes), str(path), replace_errors)


def read_lines(path: Path) -> list[str]:
    """The lines of a text file, without their ends; raises BadInput."""
    return read_text(path).splitlines()


def read_numbers(path: Path, what: str) -> Float64Array:
    """All numbers of a text file, row by row, (N,); what follows # in a line is passed over. Raises BadInput saying
    that the file must hold `what`."""
    words = [word for line in read_lines(path) for word in line.partition("#")[0].split()]
    try:
        return np.array(words, dtype=np.float64)
    except ValueError:
        raise BadInput(f"{path} must hold {what}") from None


def read_json(path: Path, *, only_finite: bool = True, max_depth: int = MAX_DEPTH) -> Any:
    """The content of a JSON file; raises BadInput naming line and column, see `parse_json`."""
    return parse_json(read_text(path), str(path), only_finite=only_finite, max_depth=max_depth)


def parse_json(text: str | bytes, name: str, *, only_finite: bool = True, max_depth: int = MAX_DEPTH) -> Any:
    """What a JSON text says; raises BadInput naming it, also for more than `max_depth` lists and objects in one
    another, for whole numbers of more than 40 digits and, if `only_finite`, for numbers that are not finite."""
    text = _decoded(text, name) if isinstance(text, bytes) else text
    hooks: dict[str, Any] = {}
    if only_finite:
        hooks["parse_constant"] = _refuse_number
    if _LARGE_NUMBERS.search(text):
        hooks["parse_int"] = _bounded_int
        if only_finite:
            hooks["parse_float"] = _finite_float
    try:
        content = json.loads(text, **hooks)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise BadInput(f"{name} cannot be read: {where} is not JSON ({error.msg}), correct or write it anew") from None
    except RecursionError:
        _refuse_depth(name, max_depth)
    except ValueError as error:
        raise BadInput(f"{name} cannot be read: {one_line(error)}") from None
    _require_depth(content, name, max_depth)
    if _SURROGATES.search(text):
        _require_characters(content, name)
    return content


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file; raises BadInput."""
    return parse_toml(read_text(path, max_bytes=MAX_TOML_BYTES), str(path))


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """What a TOML text says; raises BadInput naming it, also for sections or lists that lie more than 64
    deep in one another, and for whole numbers of more than 40 digits."""
    if _MANY_PARTS.search(text):
        _refuse_depth(name, MAX_DEPTH)
    try:
        content = tomllib.loads(text)
    except RecursionError:
        _refuse_depth(name, MAX_DEPTH)
    except ValueError as error:
        raise BadInput(f"{name}: not TOML: {one_line(error)}") from None
    _require_depth(content, name, MAX_DEPTH)
    if _LARGE_NUMBERS.search(text):
        _require_small_integers(content, name)
    return content


def _decoded(data: bytes, name: str, replace_errors: bool = False) -> str:
    try:
        text = data.decode("utf-8-sig", "replace" if replace_errors else "strict")
    except UnicodeDecodeError as error:
        line, byte = data.count(b"\n", 0, error.start) + 1, data[error.start]
        where = f"line {line} is no UTF-8 text (byte {byte:#04x})"
        raise BadInput(f"{name} cannot be read: {where}, save it as UTF-8") from None
    if "\0" in text and not replace_errors:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise BadInput(f"{name} cannot be read: line {line} has a NUL character, it is no text file or a damaged one")
    return text


def _refuse_number(text: str) -> NoReturn:
    shown = text if len(text) <= MAX_DIGITS else f"{text[:MAX_DIGITS]}..."
    raise ValueError(f"the number {shown} is not finite, or too large")


def _bounded_int(text: str) -> int:
    return int(text) if len(text) <= MAX_DIGITS else _refuse_number(text)


def _finite_float(text: str) -> float:
    number = float(text)
    return number if math.isfinite(number) else _refuse_number(text)


def _refuse_depth(name: str, max_depth: int) -> NoReturn:
    raise BadInput(f"{name} has more than {max_depth} lists or sections in one another: write it flatter") from None


def _require_depth(content: Any, name: str, max_depth: int) -> None:
    level = [content]
    for _ in range(max_depth + 1):
        level = _children(level)
        if not level:
            return
    _refuse_depth(name, max_depth)


def _children(level: list[Any]) -> list[Any]:
    """The values in the lists and objects of one level that are lists or objects or hold such as members."""
    return [
        value
        for each in level
        if isinstance(each, dict | list)
        for value in (each.values() if isinstance(each, dict) else each)
        if isinstance(value, dict | list)
    ]


def _require_characters(content: Any, name: str) -> None:
    try:
        json.dumps(content, ensure_ascii=False).encode()
    except UnicodeEncodeError:
        raise BadInput(f"{name} has half a character, such as \\ud800, in a text: correct it") from None


def _require_small_integers(content: dict[str, Any], name: str) -> None:
    level: list[Any] = [content]
    while level:
        values = [v for each in level for v in (each.values() if isinstance(each, dict) else each)]
        if any(isinstance(value, int) and abs(value) >= 10**MAX_DIGITS for value in values):
            raise BadInput(f"{name} has a whole number of more than {MAX_DIGITS} digits: give a smaller one")
        level = [value for value in values if isinstance(value, dict | list)]
