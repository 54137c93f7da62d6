"""Each command that README and docs give is one that the program understands, to the last option."""

from __future__ import annotations

import pytest
from cyclopts import CycloptsError, UnknownCommandError, UnknownOptionError, UnusedCliTokensError

from app.cli import app
from tests.support.page_commands import PAGES, ROOT, calls, in_blocks, in_text


def understand(line: str) -> None:
    """Read a command as the program does; raises what that raises."""
    for arguments in calls(line):
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
    assert sum(len(in_blocks(page)) for page in PAGES) > 50
    assert sum(len(in_text(page)) for page in PAGES) > 100
    assert len(in_blocks(ROOT / "README.md")) >= 1


def test_calls_of_a_line_are_told_apart():
    line = ".venv/bin/razer run FOLDER -o OUT && razer query OUT 'a red chair' | head  # a comment"
    assert calls(line) == [["run", "FOLDER", "-o", "OUT"], ["query", "OUT", "a red chair"]]


@pytest.mark.parametrize("line", ["razer run FOLDER -o OUT --strides 2", ".venv/bin/razer runs FOLDER -o OUT"])
def test_what_is_no_command_is_found_out(line):
    with pytest.raises(CycloptsError):
        understand(line)
