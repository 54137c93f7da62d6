"""The engine of a cluster: each task is one of Ray's, which does what the engine of one machine does."""

from __future__ import annotations

import math
import os
import warnings
from contextlib import suppress
from dataclasses import replace
from logging import ERROR
from threading import Event

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # nobody is told what is computed

import ray
from ray.exceptions import GetTimeoutError, OutOfMemoryError, RayError, RayTaskError

from app.engines.task import Needs, Outcome, Task
from razer.errors import BadInput

_AHEAD = 2.0  # tasks that wait in Ray's queue, a share of those that run: an autoscaler goes by them
_AT_LEAST = 8
_BYTES = 1_000_000


def attempt(task: Task) -> Outcome:
    """What a worker does."""
    node_id = ray.get_runtime_context().get_node_id()
    outcome = task.run(Event())
    return replace(outcome, node=f"{outcome.node} {node_id[:8]}", node_id=node_id)


class RayEngine:
    """Ray places tasks by the CPUs, memory and GPUs that they ask for, and tells of workers and nodes that died. It
    repeats none by itself: attempts are counted, logged, and ask for more memory where that ran out."""

    def __init__(self, address: str, workers: int | None = None) -> None:
        """Join a cluster; raises BadInput where there is none. workers: at most so many tasks at once."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what keeps it from joining is told by the error that follows
                ray.init(address=address, log_to_driver=False, logging_level=ERROR)
        except (ConnectionError, RuntimeError, ValueError, TimeoutError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise BadInput(f"--address {address}: no Ray cluster answers ({why})") from error
        self._workers = workers
        self._running: dict[ray.ObjectRef, Task] = {}
        self._remote = ray.remote(max_retries=0)(attempt)

    @property
    def most(self) -> Needs:
        """The most that a node has; without bounds as long as none for work is there."""
        nodes = [node["Resources"] for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU")]
        if not nodes:
            return Needs(math.inf, math.inf, math.inf)
        most_bytes = max(float(node.get("memory", math.inf)) for node in nodes)
        return Needs(max(float(node["CPU"]) for node in nodes), most_bytes / _BYTES, math.inf)

    def has_room(self, needs: Needs) -> bool:
        """Whether fewer tasks were handed over than Ray should know of: those that run, and as many that wait."""
        if self._workers is not None:
            return len(self._running) < self._workers
        slots = ray.cluster_resources().get("CPU", 0.0) / max(needs.cpus, 0.01)
        return len(self._running) < max(_AHEAD * slots, _AT_LEAST)

    def submit(self, task: Task) -> None:
        """Hand it over; not to the node that failed it before, while there are others."""
        needs = task.needs
        others = [node for node in ray.nodes() if node["Alive"] and node["NodeID"] != task.avoid]
        is_choosy = bool(task.avoid) and any(node["Resources"].get("CPU", 0.0) >= needs.cpus for node in others)
        reference = self._remote.options(
            num_cpus=needs.cpus,
            memory=int(needs.memory_mb * _BYTES),
            num_gpus=needs.gpus,
            name=f"razer {task.name} {task.number}",
            label_selector={"ray.io/node-id": f"!{task.avoid}"} if is_choosy else None,
        ).remote(task)
        self._running[reference] = task

    def wait(self, timeout_s: float) -> list[Outcome]:
        """The attempts that ended."""
        if not self._running:
            return []
        done, _ = ray.wait(list(self._running), num_returns=1, timeout=timeout_s)
        return [_outcome(reference, self._running.pop(reference)) for reference in done]

    def close(self) -> None:
        """End all tasks, and leave the cluster; the run of a worker that is killed ends with it."""
        for reference in self._running:
            with suppress(RayError):
                ray.cancel(reference, force=True)
        self._running.clear()
        ray.shutdown()


def _outcome(reference: ray.ObjectRef, task: Task) -> Outcome:
    name = task.name
    try:
        return ray.get(reference, timeout=60.0)
    except OutOfMemoryError as error:
        return Outcome(name, f"Ray ended the worker, as memory ran out: {_first_line(error)}", "memory")
    except RayTaskError as error:
        return Outcome(name, f"the worker could not begin: {str(error).splitlines()[-1]}", "elsewhere", log=str(error))
    except (RayError, GetTimeoutError) as error:
        return Outcome(name, f"worker or node lost ({type(error).__name__}): {_first_line(error)}", "elsewhere")


def _first_line(error: Exception) -> str:
    return next((line.strip() for line in str(error).splitlines() if line.strip()), "")
