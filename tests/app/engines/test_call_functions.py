"""Functions called on an engine: results in order, attempts, what fails for good, and what is learnt of memory."""

from __future__ import annotations

import errno
import os
import pickle
import signal
import sys
import warnings
from pathlib import Path
from threading import Event

import pytest

from app.console.streams import PlainConsole, print_notes
from app.engines.call_functions import CallFailed, NamedCall, call_functions
from app.engines.called_function import Call, CallTask
from app.engines.local_engine import LocalEngine
from app.engines.task import Needs, Outcome
from razer.errors import BadInput

QUIET = PlainConsole(quiet=True)
NEEDS = Needs(1.0, 100.0)


def square(number: int) -> tuple[int, int]:
    return number * number, os.getpid()


def refuse(what: str) -> None:
    raise BadInput(f"{what} cannot be used")


def divide(number: int) -> float:
    return number / 0


def die_once(marker: Path) -> str:
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def calls(function: object, *arguments: object) -> list[NamedCall]:
    return [NamedCall(str(one), Call(function, (one,)), NEEDS) for one in arguments]


def test_results_come_in_the_order_of_the_calls_from_processes_of_their_own():
    found = call_functions(calls(square, 3, 1, 2), LocalEngine(2), QUIET, things="numbers")
    assert [(name, value[0]) for name, value in found.items()] == [("3", 9), ("1", 1), ("2", 4)]
    assert len({value[1] for value in found.values()} | {os.getpid()}) == 4


def test_one_that_is_killed_is_called_again(tmp_path, capsys):
    console = PlainConsole(stderr=True)
    found = call_functions(calls(die_once, tmp_path / "marker"), LocalEngine(1), console, things="calls")
    assert list(found.values()) == ["done"]
    assert "is tried again: killed by the system" in capsys.readouterr().err


def test_what_cannot_be_used_is_one_line_and_ends_all():
    with pytest.raises(BadInput, match=r"^this cannot be used$"):
        call_functions(calls(refuse, "this"), LocalEngine(1), QUIET, things="calls")


def test_an_error_keeps_its_traceback():
    with pytest.raises(CallFailed, match=r"(?s)ZeroDivisionError.*in divide"):
        call_functions(calls(divide, 1), LocalEngine(1), QUIET, things="calls")


def remark(what: str) -> None:
    print_notes([f"{what} is strange"] * 2)
    warnings.warn(f"{what} is doubtful", UserWarning, stacklevel=2)
    print("3/12 under way", file=sys.stderr)
    if what == "bad":
        raise BadInput("it cannot be used")


def test_what_a_call_remarks_is_told_with_its_name_whether_or_not_it_fails(capsys):
    call_functions(calls(remark, "left", "right"), LocalEngine(1), QUIET, things="calls")
    assert sorted(capsys.readouterr().err.splitlines()) == sorted(
        f"{kind}: {name}: {name} is {what}"
        for name in ("left", "right")
        for kind, what in (("note", "strange"), ("WARNING", "doubtful"))
    )
    with pytest.raises(BadInput, match=r"^it cannot be used$"):
        call_functions(calls(remark, "bad"), LocalEngine(1), QUIET, things="calls")
    assert capsys.readouterr().err.splitlines() == ["note: bad: bad is strange", "WARNING: bad: bad is doubtful"]


def fill(target: Path) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(target))


def test_no_room_is_tried_again_and_one_plain_line_in_the_end(tmp_path, capsys):
    console = PlainConsole(stderr=True)
    with pytest.raises(BadInput, match=r"full: .*full: No space left on device: free some space"):
        call_functions(calls(fill, tmp_path / "full"), LocalEngine(1), console, things="calls")
    assert capsys.readouterr().err.count("is tried again") == 2
    engine = ScriptedEngine(*[("killed by the system", "memory", 0.0)] * 3)
    with pytest.raises(BadInput, match=r"^1: killed by the system$"):
        call_functions(calls(square, 1), engine, QUIET, things="calls")


class ScriptedEngine:
    """One call after the other, answered as the test says."""

    def __init__(self, *outcomes: tuple[str, str, float]) -> None:
        self.outcomes, self.tasks, self.most, self.is_closed = [*outcomes], list[CallTask](), Needs(4, 5000), False
        self._open: list[CallTask] = []

    def has_room(self, needs: Needs) -> bool:
        return not self._open

    def submit(self, task: CallTask) -> None:
        self.tasks.append(task)
        self._open.append(task)

    def wait(self, timeout_s: float) -> list[Outcome]:
        if not self._open:
            return []
        task, (reason, remedy, peak_mb) = self._open.pop(), self.outcomes.pop(0)
        return [Outcome(task.name, reason, remedy, peak_mb=peak_mb, result=pickle.dumps(task.name))]

    def close(self) -> None:
        self.is_closed = True


def test_memory_is_doubled_where_it_ran_out_and_learnt_from_calls_that_ended():
    engine = ScriptedEngine(("killed", "memory", 0.0), ("", "none", 900.0), ("", "none", 50.0))
    call_functions(calls(square, 1, 2), engine, QUIET, things="calls")
    assert [(task.name, task.number) for task in engine.tasks] == [("1", 1), ("2", 1), ("1", 2)]
    assert [task.needs.memory_mb for task in engine.tasks] == pytest.approx([100.0, 100.0, 2 * 1.2 * 900.0])
    assert engine.is_closed


def test_attempts_are_bounded_and_the_engine_is_closed_whatever_happens():
    engine = ScriptedEngine(*[("lost", "elsewhere", 0.0)] * 9)
    with pytest.raises(CallFailed, match="lost"):
        call_functions(calls(square, 1), engine, QUIET, things="calls")
    assert (len(engine.tasks), engine.is_closed) == (3, True)


def test_a_call_that_is_given_up_has_no_result():
    stop = Event()
    stop.set()
    outcome = CallTask("one", Call(square, (1,)), NEEDS, "/").run(stop)
    assert not outcome.is_done
    assert "given up" in outcome.reason
