"""Each command that README and docs give is one that the program understands, to the last option."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from cyclopts import CycloptsError, UnknownCommandError, UnknownOptionError, UnusedCliTokensError

from app.cli import app

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"^```(?:sh|bash|console)\n(.*?)^```", re.M | re.S)


def in_blocks(page: Path) -> list[str]:
    """The lines of a page's blocks that call the program."""
    lines = (block.replace("\\\n", " ").splitlines() for block in _BLOCK.findall(page.read_text(encoding="utf-8")))
    return [line.strip() for block in lines for line in block if re.match(r"\s*razer [a-z]", line)]


def in_text(page: Path) -> list[str]:
    """What a page's text says of calls; it may leave out what is plain, and have N for a number."""
    text = _BLOCK.sub("", page.read_text(encoding="utf-8"))
    spoken = [" ".join(code.split()) for code in re.findall(r"`(razer [a-z][^`]*)`", text)]
    return [line for line in spoken if "..." not in line and "…" not in line]


def parts(line: str) -> list[list[str]]:
    """The arguments of each call of the program in a line."""
    words, calls = shlex.split(line, comments=True), []
    for word in words:
        if word in ("&&", ";", "|", "||"):
            calls.append([])
        else:
            (calls or [[]])[-1].append(word) if calls else calls.append([word])
    return [call[1:] for call in calls if call and call[0] == "razer"]


def understand(line: str) -> None:
    """Read a command as the program does; raises what that raises."""
    for arguments in parts(line):
        app.parse_args(arguments, exit_on_error=False, print_error=False)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_commands_of_a_page_are_understood(page):
    wrong = {}
    for line in (*in_blocks(page), *in_text(page)):
        try:
            understand(line)
        except (UnknownCommandError, UnknownOptionError, UnusedCliTokensError) as error:
            wrong[line] = str(error)
        except CycloptsError as error:
            if line in in_blocks(page):
                wrong[line] = str(error)
    assert wrong == {}


def test_there_are_commands_to_be_understood():
    assert sum(len(in_blocks(page)) for page in PAGES) > 30
    assert sum(len(in_text(page)) for page in PAGES) > 100


def test_what_is_no_command_is_found_out():
    with pytest.raises(CycloptsError):
        understand("razer run FOLDER -o OUT --strides 2")
