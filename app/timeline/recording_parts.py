"""Parts of a recording: files that are written side by side, and joined in the order in which a viewer reads them."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import BinaryIO

from app.timeline.viewer import live_files
from app.timeline.viewer.rerun_process import rerun_command, rerun_environment

JOIN_TIMEOUT_S = 120.0


class RecordingParts:
    """The parts of the recording `path`, beside it."""

    def __init__(self, path: Path, count: int) -> None:
        self._path = path
        self.paths = [path.with_name(f"{path.stem}.{number}{path.suffix}") for number in range(count)]
        self._locks: list[BinaryIO] = []

    def lock(self) -> None:
        """Let readers know that the parts are being written."""
        self._locks = [live_files.lock(path) for path in self.paths]

    def unlock(self) -> None:
        """Let readers know that nothing more will come."""
        for file in self._locks:
            file.close()

    def join(self) -> None:
        """Write the parts one after the other into the recording, and remove them."""
        joined = self._path.with_name(f"{self._path.name}.joined")
        command = rerun_command("rrd", "route", *map(str, self.paths), "-o", str(joined))
        done = subprocess.run(
            command, env=rerun_environment(), capture_output=True, text=True, timeout=JOIN_TIMEOUT_S, check=False
        )
        if done.returncode != 0:
            raise OSError(f"the parts of {self._path} could not be joined: {done.stderr.strip()[-300:]}")
        joined.replace(self._path)
        for part in self.paths:
            part.unlink()
