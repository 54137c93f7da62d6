"""A seeded mutator of files: bits, pieces, hostile tokens, and one file's bytes in another's place."""

from __future__ import annotations

import io
import random
import re
import struct
import zipfile
from collections.abc import Sequence

MAX_BYTES = 2**21
TOKENS = (
    b"\xff\xfe", b"\x80", b"\0", b"[" * 100_000, b'{"a":' * 20_000, b"9" * 5_000, b"-" + b"9" * 400, b"1e999",
    b"-1e308", b"NaN", b"nan", b"Infinity", b"-Infinity", b"inf", b"null", b"true", b"0", b"-1", b"1.5", b"2147483648",
    b"18446744073709551616", b'""', b"[]", b"{}", b"[[]]", b"../../../etc/passwd", b"/dev/zero", b"a" * 70_000,
    b"\n" * 3000,    b"a." * 5_000, b"\x1b[31m", b"\r\n\r\n", b"\xe2\x80\xa8", b"%s%n", b"__class__", b"builtins:eval",
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\"[^\"\n]{0,40}\"")
_SIZES = (0, 1, 255, 65535, 2**31 - 1, 2**31, 2**32 - 1)


def mutated(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    """A changed copy of a file's bytes; `others` are those of the files beside it."""
    if data[:4] == b"PK\x03\x04" and rng.random() < 0.5:
        return _archive(data, others, rng)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = rng.choice(_CHANGES)(data, others, rng)[:MAX_BYTES]
    return data


def _bits(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _i in range(rng.choice((1, 1, 2, 8, 64))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _header_bits(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    return _bits(data[:128], others, rng) + data[128:]


def _cut(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _doubled(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    first, last = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[:last] + data[first:last] + data[last:]


def _dropped(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    first, last = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[:first] + data[last:]


def _with_token(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(TOKENS) + data[at:]


def _with_value(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    """One number or text replaced by a hostile one."""
    values = list(_NUMBER.finditer(data[:100_000]))
    if not values:
        return _with_token(data, (), rng)
    value = rng.choice(values)
    return data[: value.start()] + rng.choice(TOKENS) + data[value.end() :]


def _with_size(data: bytes, _: Sequence[bytes], rng: random.Random) -> bytes:
    """Four bytes, of the beginning rather than of the rest, replaced by a size."""
    at = rng.randrange(min(len(data), rng.choice((64, 512, len(data) + 1))) + 1)
    return data[:at] + struct.pack(rng.choice("<>") + "I", rng.choice(_SIZES)) + data[at + 4 :]


def _swapped(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    return rng.choice(others) if others else data


def _emptied(_data: bytes, _others: Sequence[bytes], _rng: random.Random) -> bytes:
    return b""


_CHANGES = (
    _bits, _bits, _header_bits, _cut, _doubled, _dropped, _with_token, _with_value, _with_value, _with_value,
    _with_size,    _swapped, _emptied,
)  # fmt: skip


def _archive(data: bytes, others: Sequence[bytes], rng: random.Random) -> bytes:
    """An archive that is whole, with one member changed, gone, or in another's place."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice(list(members))
    match rng.randrange(4):
        case 0:
            del members[name]
        case 1:
            members[name] = rng.choice(list(members.values()))
        case _:
            changes = [change for change in _CHANGES if change is not _swapped]
            members[name] = rng.choice(changes)(members[name], others, rng)
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return target.getvalue()
