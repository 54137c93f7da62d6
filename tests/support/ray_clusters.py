"""Ray clusters on this machine, for tests, whose nodes are processes of their own."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil
from ray.util import get_node_ip_address

RAY = Path(sys.executable).with_name("ray")
ENVIRONMENT = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_raylet_start_wait_time_s": "150"}
_ANY_PORTS = ("dashboard-agent-listen", "dashboard-agent-grpc", "metrics-export", "min-worker", "max-worker")
_PORTS = tuple(f"--{name}-port=0" for name in _ANY_PORTS)  # several nodes have one address here
_QUIET = ("--disable-usage-stats", "--include-log-monitor=false", "--block")


@dataclass
class LoopbackCluster:
    """address: what --address takes. nodes: `ray start` of each node, in order."""

    address: str
    head: subprocess.Popen[bytes]
    nodes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def kill_node(self, index: int) -> None:
        """Kill the raylet of a node, as a power cut would, and nothing else of it."""
        (raylet,) = [one for one in _below(self.nodes[index]) if one.name() == "raylet"]
        raylet.send_signal(signal.SIGKILL)

    def cpu_s(self) -> float:
        """Processor time of all processes of the cluster but those that map: its own."""
        members = [process for started in (self.head, *self.nodes) for process in _below(started)]
        return sum(_cpu_s(process) for process in members if not _maps(process))


@contextmanager
def loopback_cluster(
    n_nodes: int, cpus: int = 1, memory_mb: int = 4000, port: int = 0, head_cpus: int = 0
) -> Iterator[LoopbackCluster]:
    """A head and `n_nodes` others, started by `ray start` as on machines of their own, which talk over sockets."""
    folder = tempfile.mkdtemp(prefix="ray-")  # short: paths of sockets are bounded
    port = port or _free_port()
    head = _start(
        folder,
        "--head",
        f"--port={port}",
        f"--num-cpus={head_cpus}",
        "--include-dashboard=false",
        f"--temp-dir={folder}",
    )
    cluster = LoopbackCluster(f"{get_node_ip_address()}:{port}", head)
    try:
        _wait_until_started(folder, 1)
        for index in range(n_nodes):  # one after the other: two that begin at once take the same port
            memory = (f"--memory={memory_mb * 1_000_000}", "--object-store-memory=80000000")
            cluster.nodes.append(_start(folder, f"--address={cluster.address}", f"--num-cpus={cpus}", *memory))
            _wait_until_started(folder, 2 + index)
        yield cluster
    finally:
        for process in (*cluster.nodes, head):
            _end(process)
        shutil.rmtree(folder, ignore_errors=True)


def _start(folder: str, *options: str) -> subprocess.Popen[bytes]:
    with (Path(folder) / f"start-{time.monotonic_ns()}.log").open("wb") as log:
        command = [str(RAY), "start", *options, *_PORTS, *_QUIET]
        environment = {**os.environ, **ENVIRONMENT}
        return subprocess.Popen(command, stdout=log, stderr=log, env=environment, start_new_session=True)


def _below(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    with suppress(psutil.NoSuchProcess):
        parent = psutil.Process(process.pid)
        return [parent, *parent.children(recursive=True)]
    return []


def _maps(process: psutil.Process) -> bool:
    with suppress(psutil.Error):
        return any(
            word in ("app", "held_launch.py") or word.startswith("from multiprocessing") for word in process.cmdline()
        )
    return True


def _cpu_s(process: psutil.Process) -> float:
    with suppress(psutil.Error):
        times = process.cpu_times()
        return times.user + times.system
    return 0.0


def _free_port() -> int:
    with socket.socket() as opened:
        opened.bind(("127.0.0.1", 0))
        return int(opened.getsockname()[1])


def _wait_until_started(folder: str, count: int) -> None:
    """Until so many nodes say that they have; one that begins before its head has is never heard of."""
    deadline_s = time.monotonic() + 200
    while sum("ray stop" in log.read_text() for log in Path(folder).glob("start-*.log")) < count:
        assert time.monotonic() < deadline_s, [log.read_text() for log in Path(folder).glob("start-*.log")]
        time.sleep(0.2)


def _end(process: subprocess.Popen[bytes]) -> None:
    members = _below(process)
    for member in members:
        with suppress(psutil.NoSuchProcess):
            member.kill()
    psutil.wait_procs(members, timeout=10)
    process.wait()
