"""No verb reaches for the network unasked: neither Python, helper processes included, nor the libraries below it."""

from __future__ import annotations

import ipaddress
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from tests.support.cli import QUICK
from tests.support.hub_cache import put_starter

REFUSED = Path(__file__).parents[1] / "support" / "no_network"
NOWHERE = "192.0.2.1"  # for documentation: nobody has it
# Joining a socket of datagrams sends nothing.
REACH_OUT = "import socket; socket.socket(socket.AF_INET, socket.SOCK_DGRAM).connect(('192.0.2.1', 9))"
ORACLE = ("--segmenter", "oracle", "--embedder", "oracle")


class Watched(NamedTuple):
    """A folder with what was tried: lines of Python's processes, and system calls where strace is there."""

    tried: Path
    calls: Path

    def run(self, *command: object, refused: bool = True) -> subprocess.CompletedProcess[str]:
        """Run a program under watch; nobody says that it is offline, and it finds no models but those it is given."""
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("HF_", "TRANSFORMERS_"))}
        home = self.tried.with_name("home")
        environment |= {"HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache"), "NO_NETWORK_LOG": str(self.tried)}
        for name in ("XDG_CONFIG_HOME", "ORT_DISABLE_TELEMETRY"):
            environment.pop(name, None)
        if refused:
            paths = (str(REFUSED), environment.get("PYTHONPATH", ""))
            environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        watch = ("strace", "-f", "--seccomp-bpf", "-A", "-o", self.calls, "-e", "trace=connect,sendto,sendmsg")
        arguments = [str(part) for part in ((*watch, *command) if can_strace() else command)]
        return subprocess.run(arguments, env=environment, capture_output=True, text=True, timeout=500, check=False)

    def razer(self, *arguments: object) -> None:
        """Run a verb, which has to succeed."""
        done = self.run(sys.executable, "-m", "app", *arguments)
        assert done.returncode == 0, done.stderr

    def left_the_machine(self) -> list[str]:
        """System calls to any address but this machine's own, and questions to a name server."""
        return [line for line in self.calls.read_text().splitlines() if not _stays_here(line)]


def can_strace() -> bool:
    """Whether there is strace, and whether it may."""
    if shutil.which("strace") is None:
        return False
    return (
        subprocess.run(
            ["strace", "-f", "--seccomp-bpf", "-o", os.devnull, "true"], capture_output=True, check=False
        ).returncode
        == 0
    )


def _stays_here(line: str) -> bool:
    address = re.search(r'inet_addr\("([^"]+)"\)|inet_pton\(AF_INET6, "([^"]+)"', line)
    if address is None:
        return True
    found = ipaddress.ip_address(address[1] or address[2])
    return (found.is_loopback or found.is_unspecified) and "htons(53)" not in line


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory) -> Watched:
    """What all verbs together tried."""
    place = tmp_path_factory.mktemp("watched")
    watch = Watched(place / "tried", place / "calls")
    watch.tried.touch()
    room = SyntheticRoom(0, 16, 160, 120)
    recording, given, slam, models = (place / name for name in ("recording", "given", "slam", "models"))
    write_recording(room, recording, truth=room.truth(0.05), lossless=True)
    watch.razer("run", recording, "-o", given, *ORACLE, *QUICK)
    watch.razer("run", recording, "-o", slam, "--poses", "slam", *ORACLE, *QUICK)
    watch.razer("query", given, "a chair")
    watch.razer("view", given, "--picture", place / "map.png")
    watch.razer("view", given, "--page", place / "map.html")
    watch.razer("eval", given, "--truth", recording)
    put_starter(place / "cache")
    weights = {path.parents[1].name: path for path in (place / "cache").glob("*/snapshots/*")}
    detector, surfaces, words = (next(p for name, p in weights.items() if part in name) for part in PARTS)
    options = (f"rfdetr.weights={next(detector.glob('*.onnx'))}", f"semantic.weights={surfaces}")
    chosen = [("--set", f"segmenter.options.{option}") for option in options]
    chosen += [("--set", f"embedder.options.weights={words}")]
    names = ("--segmenter", "rfdetr+semantic", "--embedder", "clip")
    watch.razer("run", recording, "-o", models, *names, *(part for pair in chosen for part in pair), *QUICK)
    watch.razer("query", models, "a chair")
    watch.razer("compare", given, models, "--truth", recording)
    watch.razer("models", "list")
    return watch


PARTS = ("rfdetr", "upernet", "clip")


@pytest.mark.full
def test_no_process_of_python_reaches_out(watched: Watched) -> None:
    assert watched.tried.read_text() == ""


@pytest.mark.full
def test_no_library_reaches_out(watched: Watched) -> None:
    if not can_strace():
        pytest.skip("needs strace: what Rust and C++ do is seen in system calls only")
    assert watched.left_the_machine() == []


def test_what_reaches_out_is_seen(tmp_path: Path) -> None:
    watch = Watched(tmp_path / "tried", tmp_path / "calls")
    # In a process below the one that is started, as helpers are.
    below = f"import subprocess, sys; sys.exit(subprocess.run([sys.executable, '-c', {REACH_OUT!r}]).returncode)"
    done = watch.run(sys.executable, "-c", below)
    assert done.returncode == 1
    assert "socket.connect is refused here" in done.stderr
    assert NOWHERE in watch.tried.read_text()
    looked_up = watch.run(sys.executable, "-c", "import socket; socket.getaddrinfo('example.org', 443)")
    assert looked_up.returncode == 1
    assert "example.org" in watch.tried.read_text().splitlines()[-1]
    here = "import socket; s = socket.create_server(('127.0.0.1', 0)); socket.create_connection(s.getsockname())"
    assert watch.run(sys.executable, "-c", here).returncode == 0
    assert len(watch.tried.read_text().splitlines()) == 2


def test_a_system_call_that_leaves_the_machine_is_seen(tmp_path: Path) -> None:
    if not can_strace():
        pytest.skip("needs strace")
    watch = Watched(tmp_path / "tried", tmp_path / "calls")
    assert watch.run(sys.executable, "-c", REACH_OUT, refused=False).returncode == 0
    assert [NOWHERE in line for line in watch.left_the_machine()] == [True]
