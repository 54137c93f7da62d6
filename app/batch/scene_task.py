"""What is asked of an engine, one scene at a time, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Remedy = Literal["none", "elsewhere", "memory"]


@dataclass(frozen=True)
class Needs:
    """What a scene asks for while it is mapped: CPUs, memory in 10^6 bytes, GPUs."""

    cpus: float
    memory_mb: float
    gpus: float = 0.0

    def within(self, most: Needs) -> Needs:
        """The same, but no more of anything than there is anywhere."""
        return Needs(min(self.cpus, most.cpus), min(self.memory_mb, most.memory_mb), min(self.gpus, most.gpus))


@dataclass(frozen=True)
class SceneTask:
    """One attempt at one scene; it travels to other machines.

    name: of the scene. recording, out: path or URI of the recording and of the run folder to be made. words: options of
    `razer run`. config: content of a --config file, None = none. working_folder: what relative paths of the options are
    relative to. needs: what is kept free for it. cores: to how many cores it is held, 0 = to none. number: of the
    attempt, from 1. avoid: node that failed it before, "" = none. truth_preset: by whose rules the map is evaluated,
    "" = not at all.
    """

    name: str
    recording: str
    out: str
    words: tuple[str, ...]
    needs: Needs
    working_folder: str
    config: str | None = None
    cores: int = 0
    number: int = 1
    avoid: str = ""
    truth_preset: str = ""


@dataclass(frozen=True)
class Outcome:
    """What became of an attempt.

    reason: why it failed, "" where it did not. remedy: what lets another attempt hope: another node, more memory, or
    nothing. seconds: from its start on the node to its end; cpu_s, peak_mb: processor time and resident memory of its
    processes. node: where; node_id: what the engine calls it. log: the last that its run said. evaluation: the pickled
    result of the evaluation, and why there is none where one was asked for.
    """

    task: SceneTask
    reason: str = ""
    remedy: Remedy = "none"
    seconds: float = 0.0
    cpu_s: float = 0.0
    peak_mb: float = 0.0
    node: str = ""
    node_id: str = ""
    log: str = ""
    evaluation: bytes | None = None
    not_evaluated: str = ""

    @property
    def is_done(self) -> bool:
        """Whether the run folder of the scene is there, whole."""
        return not self.reason
