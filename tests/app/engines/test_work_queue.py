"""The queue of an engine: the longest first where there is room, and nothing left running."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from app.engines.task import Needs, Outcome
from app.engines.work_queue import MAX_ATTEMPTS, Ended, WorkQueue


@dataclass(frozen=True)
class Piece:
    """Work and its task at once."""

    name: str
    seconds: float
    memory_mb: float = 10.0
    number: int = 0
    avoid: str = ""

    def needs(self, n_short_of_memory: int) -> Needs:
        return Needs(1.0, self.memory_mb * 2**n_short_of_memory)

    def task(self, needs: Needs, number: int, avoid: str) -> Piece:
        return replace(self, memory_mb=needs.memory_mb, number=number, avoid=avoid)

    def checked(self, outcome: Outcome) -> Outcome:
        return outcome


class Machine:
    """Room for so much memory at once; tasks end in the order of their names, as `reasons` says."""

    def __init__(self, memory_mb: float, **reasons: list[tuple[str, str]]) -> None:
        self.most, self.running, self.begun, self.is_closed = Needs(8, memory_mb), list[Piece](), list[Piece](), False
        self.reasons = reasons

    def has_room(self, needs: Needs) -> bool:
        return sum(piece.memory_mb for piece in self.running) + needs.memory_mb <= self.most.memory_mb

    def submit(self, task: Piece) -> None:
        self.running.append(task)
        self.begun.append(task)

    def wait(self, timeout_s: float) -> list[Outcome]:
        if not self.running:
            return []
        self.running.sort(key=lambda piece: piece.name)
        piece = self.running.pop(0)
        reasons = self.reasons.get(piece.name, [])
        reason, remedy = reasons.pop(0) if reasons else ("", "none")
        return [Outcome(piece.name, reason, remedy, node_id=f"n{piece.number}")]

    def close(self) -> None:
        self.running.clear()
        self.is_closed = True


def worked(queue: WorkQueue[Piece]) -> list[Ended[Piece]]:
    return [ended for several in queue.work() for ended in several]


def test_the_longest_begins_first_and_a_shorter_one_where_only_it_fits():
    machine = Machine(100)
    queue = WorkQueue([Piece("a", 1, 30), Piece("b", 3, 70), Piece("c", 2, 60)], machine)
    ended = worked(queue)
    assert [piece.name for piece in machine.begun] == ["b", "a", "c"]
    assert {one.work.name for one in ended if one.is_last} == {"a", "b", "c"}


def test_a_node_that_failed_is_avoided_and_attempts_are_bounded():
    machine = Machine(100, a=[("lost", "elsewhere")] * 9, b=[("wrong", "none")] * 9)
    ended = worked(WorkQueue([Piece("a", 1), Piece("b", 2)], machine))
    assert [(piece.number, piece.avoid) for piece in machine.begun if piece.name == "a"] == [
        (1, ""),
        (2, "n1"),
        (3, "n2"),
    ]
    assert [one.is_last for one in ended if one.work.name == "a"] == [False, False, True]
    assert [one.is_last for one in ended if one.work.name == "b"] == [True]
    assert MAX_ATTEMPTS == 3


def test_memory_that_ran_out_is_doubled_up_to_what_there_is():
    machine = Machine(35, a=[("killed", "memory")] * 2)
    worked(WorkQueue([Piece("a", 1)], machine))
    assert [piece.memory_mb for piece in machine.begun] == [10, 20, 35]


def test_when_it_is_left_early_what_just_ended_is_told_and_nothing_runs():
    machine = Machine(100)
    queue = WorkQueue([Piece("a", 3, 50), Piece("b", 2, 50), Piece("c", 1, 50)], machine)
    last, steps = list[Ended[Piece]](), queue.work()
    with queue.closed_at_the_end(last):
        next(steps)
    assert [one.work.name for one in last] == ["b"]
    assert machine.is_closed
    assert [piece.name for piece in queue.not_done] == ["c"]


def test_two_pieces_of_one_name_are_refused_before_any_begins():
    machine = Machine(100)
    with pytest.raises(ValueError, match="2 pieces of work are called a"):
        WorkQueue([Piece("a", 1), Piece("b", 1), Piece("a", 2)], machine)
    assert machine.begun == []
