"""A library whose threads are stuck keeps neither the program from ending, nor a caller of its from going on."""

from __future__ import annotations

import subprocess
import sys

import pytest

from app.console import leaving
from tests.support.cli import call

STUCK = """
import threading
from app.__main__ import program
from app.console.leaving import note_stuck
threading.Thread(target=threading.Event().wait).start()
note_stuck("a library")
program()
"""

CRASHES_AS_IT_ENDS = """
import atexit, os
import app.cli
from app.__main__ import program

def no_memory(*_, **__):
    raise MemoryError

atexit.register(os.abort)
app.cli.app = no_memory
program()
"""


@pytest.mark.parametrize(("arguments", "code"), [(["--version"], 0), (["run", "nowhere"], 2)])
def test_the_program_ends_with_its_code_while_a_thread_waits_for_ever(arguments, code):
    done = subprocess.run([sys.executable, "-c", STUCK, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == code
    assert "razer" in done.stderr or done.stdout[0].isdigit()  # what was printed is not lost


def test_short_of_memory_no_library_is_ended_that_may_crash():
    done = subprocess.run([sys.executable, "-c", CRASHES_AS_IT_ENDS], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr.startswith("razer: memory ran out")


def test_a_process_that_calls_the_program_goes_on(monkeypatch):
    monkeypatch.setattr(leaving, "_stuck", {"a library"})
    assert call("--version") == 0


def test_an_ending_that_is_no_number_is_told_by_python(monkeypatch):
    monkeypatch.setattr(leaving, "_stuck", {"a library"})
    with pytest.raises(SystemExit, match="in words"):
        leaving.end_process(SystemExit("in words"))
