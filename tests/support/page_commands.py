"""The commands that README and docs give, by page."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"^```(?:sh|bash|console)\n(.*?)^```", re.M | re.S)
_CALL = re.compile(r"(?:\.venv/bin/)?razer [a-z]")


def block_lines(page: Path) -> list[str]:
    """The lines of a page's shell blocks, in order; one that goes on in the next is one."""
    blocks = (block.replace("\\\n", " ").splitlines() for block in _BLOCK.findall(page.read_text(encoding="utf-8")))
    return [line.strip() for block in blocks for line in block if line.strip()]


def in_blocks(page: Path) -> list[str]:
    """Those of them that call the program."""
    return [line for line in block_lines(page) if _CALL.match(line)]


def in_text(page: Path) -> list[str]:
    """What a page's text says of calls; it may leave out what is plain, and have N for a number."""
    text = _BLOCK.sub("", page.read_text(encoding="utf-8"))
    spoken = [" ".join(code.split()) for code in re.findall(r"`(razer [a-z][^`]*)`", text)]
    return [line for line in spoken if "..." not in line and "…" not in line]


def words(line: str) -> list[str]:
    """A line as a shell splits it, without its comment."""
    return shlex.split(line, comments=True)


def calls(line: str) -> list[list[str]]:
    """The arguments of each call of the program in a line."""
    found: list[list[str]] = [[]]
    for word in words(line):
        if word in ("&&", ";", "|", "||"):
            found.append([])
        else:
            found[-1].append(word)
    return [call[1:] for call in found if call and Path(call[0]).name == "razer"]
