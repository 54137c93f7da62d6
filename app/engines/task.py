"""What an engine is handed, one attempt at a time, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event
from typing import Literal, Protocol

Remedy = Literal["none", "elsewhere", "memory", "room"]


@dataclass(frozen=True)
class Needs:
    """What a task asks for while it is at work: CPUs, memory in 10^6 bytes, GPUs."""

    cpus: float
    memory_mb: float
    gpus: float = 0.0

    def within(self, most: Needs) -> Needs:
        """The same, but no more of anything than there is anywhere."""
        return Needs(min(self.cpus, most.cpus), min(self.memory_mb, most.memory_mb), min(self.gpus, most.gpus))


class Task(Protocol):
    """One attempt at one piece of work; it travels to other machines. number: of the attempt, from 1. avoid: node that
    failed it before, "" = none."""

    @property
    def name(self) -> str:
        """Of the piece of work."""

    @property
    def needs(self) -> Needs:
        """What is kept free for it."""

    @property
    def number(self) -> int:
        """Of the attempt."""

    @property
    def avoid(self) -> str:
        """The node it should not go to."""

    def run(self, stop: Event) -> Outcome:
        """Do it, here, in processes of its own; what goes wrong is told in the outcome. When `stop` is set it is given
        up."""


@dataclass(frozen=True)
class Outcome:
    """What became of an attempt.

    name: of the task. reason: why it failed, "" where it did not. remedy: what lets another attempt hope: another node,
    more memory, room on the disk, or nothing. seconds: from its start on the node to its end; cpu_s, peak_mb: processor
    time and resident memory of its processes. node: where; node_id: what the engine calls it. log: the last that it
    said; notes: what the user should hear of that, as `notes_of` has it. result: pickled, of what was computed;
    no_result: why there is none though it was done.
    """

    name: str
    reason: str = ""
    remedy: Remedy = "none"
    seconds: float = 0.0
    cpu_s: float = 0.0
    peak_mb: float = 0.0
    node: str = ""
    node_id: str = ""
    log: str = ""
    notes: tuple[str, ...] = ()
    result: bytes | None = None
    no_result: str = ""

    @property
    def is_done(self) -> bool:
        """Whether the work is done."""
        return not self.reason
