"""`razer run --serve` in a process, as those who look on see it."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx
import psutil

from tests.support.cli import QUICK
from tests.support.served_maps import API

MODELS = ("--segmenter", "oracle", "--embedder", "oracle")


class ServedRun:
    """A run in a process, what it wrote to standard error, and its address."""

    def __init__(self, recording: Path, out: Path, *arguments: str) -> None:
        command = [sys.executable, "-m", "app", "run", recording, "-o", out, *MODELS, *QUICK, "--no-timeline"]
        command = [*map(str, command), "--serve", "--port", "0", *arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()
        address = re.search(r"http://\S+", self.until("while it grows"))
        assert address
        self.address = address[0]
        self.until("frames/s")

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line)

    def until(self, text: str, timeout_s: float = 120) -> str:
        """The first line with this text, once it is written."""
        deadline_s = time.monotonic() + timeout_s
        while time.monotonic() < deadline_s:
            for line in self.lines:
                if text in line:
                    return line
            time.sleep(0.02)
        raise AssertionError(f"'{text}' never came: {self.lines[-5:]}")

    def get(self, path: str) -> httpx.Response:
        """What the interface answers."""
        return httpx.get(f"{self.address.rstrip('/')}{API}/{path}", timeout=60)

    def post(self, path: str, content: dict[str, Any]) -> httpx.Response:
        """What the interface answers to JSON."""
        return httpx.post(f"{self.address.rstrip('/')}{API}/{path}", json=content, timeout=60)


@contextmanager
def served_run(recording: Path, out: Path, *arguments: str) -> Iterator[ServedRun]:
    """A run of a recording into a folder, and the end of it with all that it started."""
    run = ServedRun(recording, out, *arguments)
    try:
        yield run
    finally:
        with suppress(psutil.NoSuchProcess):
            for child in psutil.Process(run.process.pid).children(recursive=True):
                child.kill()
        run.process.kill()
        run.process.wait()


def a_named_thing(run: ServedRun) -> dict[str, Any]:
    """The largest thing that a run has named so far, once there is one."""
    deadline_s = time.monotonic() + 60
    while time.monotonic() < deadline_s:
        listed: dict[str, Any] = run.get("instances?kind=thing").json()
        if listed["instances"]:
            found: dict[str, Any] = max(listed["instances"], key=lambda instance: instance["vertices"])
            return found
        time.sleep(0.1)
    raise AssertionError("no thing appeared")
