"""What is waited for is told: by a spinner on a terminal, by lines elsewhere, and never when all is quiet."""

from __future__ import annotations

import io
from threading import Event

import pytest
from rich.console import Console

from app.console import waiting
from app.console.progress import show_progress
from app.console.waiting import waiting_for


class Told(io.StringIO):
    """A stream that says when enough lines of it are there."""

    def __init__(self, n_lines: int) -> None:
        super().__init__()
        self.n_lines, self.is_enough = n_lines, Event()

    def write(self, text: str) -> int:
        written = super().write(text)
        if self.getvalue().count("\n") >= self.n_lines:
            self.is_enough.set()
        return written


@pytest.fixture
def at_once(monkeypatch):
    monkeypatch.setattr(waiting, "FIRST_S", 0.01)
    monkeypatch.setattr(waiting, "AGAIN_S", 0.02)


def test_without_a_terminal_what_is_waited_for_is_a_line_and_comes_again(at_once):
    told = Told(2)
    with waiting_for("aligning the maps", Console(file=told, force_terminal=False)):
        assert told.is_enough.wait(20)
    first, second = told.getvalue().splitlines()[:2]
    assert first == "aligning the maps ..."
    assert second.startswith("aligning the maps ... (")


def test_what_is_soon_over_is_not_told():
    told = io.StringIO()
    with waiting_for("aligning the maps", Console(file=told, force_terminal=False)):
        pass
    assert told.getvalue() == ""


def test_work_that_lets_no_other_thread_run_is_told_at_once():
    told = io.StringIO()
    with waiting_for("making the page", Console(file=told, force_terminal=False), at_once=True):
        assert told.getvalue() == "making the page ...\n"


def test_a_terminal_has_it_at_once_and_not_for_good():
    screen = io.StringIO()
    with waiting_for("aligning the maps", Console(file=screen, force_terminal=True, width=40, color_system=None)):
        assert "aligning the maps" in screen.getvalue()
    assert screen.getvalue().endswith("\x1b[2K")  # the line is wiped


def test_a_dumb_terminal_has_lines(at_once, monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    told = Told(1)
    with waiting_for("aligning the maps", Console(file=told, force_terminal=True)):
        assert told.is_enough.wait(20)
    assert "\x1b" not in told.getvalue()


def test_a_quiet_console_and_a_wait_within_a_wait_say_nothing(at_once):
    told, inner = Told(1), io.StringIO()
    with waiting_for("nothing", Console(file=inner, quiet=True)):
        pass
    outer, within = (Console(file=file, force_terminal=False) for file in (told, inner))
    with waiting_for("the outer", outer), waiting_for("the inner", within):
        assert told.is_enough.wait(20)
    assert inner.getvalue() == ""
    assert "inner" not in told.getvalue()


def test_a_wait_that_fails_is_over():
    told = io.StringIO()
    with pytest.raises(ValueError, match="no map"), waiting_for("a", Console(file=told)):
        raise ValueError("no map")
    with waiting_for("b", Console(file=told, force_terminal=True, color_system=None)):
        assert " b" in told.getvalue()


@pytest.mark.parametrize("n_items", [0, 1, 7, 30])
def test_lines_count_up_to_all_and_pass_every_item_on(n_items):
    told = io.StringIO()
    console = Console(file=told, force_terminal=False)
    assert list(show_progress(range(n_items), n_items, lambda: "fine", console, things="runs")) == list(range(n_items))
    lines = told.getvalue().splitlines()
    assert len(lines) <= 10
    assert lines[-1:] == [f"{n_items}/{n_items} runs, fine"] * bool(n_items)


def test_a_narrow_bar_leaves_room_for_its_text():
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=40, color_system=None)
    assert list(show_progress(range(3), 3, lambda: "12 lost", console)) == [0, 1, 2]
    assert "3/3" in screen.getvalue()
    assert "12 lost" in screen.getvalue()
