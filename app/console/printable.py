"""Texts that a terminal does not obey."""

from __future__ import annotations


def printable(text: str) -> str:
    """A text whose control characters, but for the ends of lines, are escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)
