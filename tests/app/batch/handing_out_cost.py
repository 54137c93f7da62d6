"""What a batch itself costs a scene, with an engine that maps nothing.

python -m tests.app.batch.handing_out_cost [N ...]

Prints the processor time, milliseconds, that a further scene takes in batches of N, all of listing, handing out, taking
in and reporting in it; writing the empty map that stands for a run's is left out.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from time import process_time

from app.batch.begin import BatchPlan, begin
from app.batch.one_scene import SceneTask
from app.batch.scenes import scenes_of
from app.console.streams import PlainConsole
from app.engines.task import Needs, Outcome
from app.object_store.place import Place
from app.settings.options import RunOptions
from tests.app.batch.test_run_batch import made, recordings

WORKERS, SIZES = 1000, (100, 1000, 4000)


class Workers:
    """So many, of which one is done each time it is asked."""

    def __init__(self) -> None:
        self.most, self.making_s = Needs(8, 16_000), 0.0
        self._open: list[SceneTask] = []

    def has_room(self, needs: Needs) -> bool:
        return len(self._open) < WORKERS

    def submit(self, task: SceneTask) -> None:
        self._open.append(task)

    def wait(self, timeout_s: float) -> list[Outcome]:
        begun_s = process_time()
        ended = [made(self._open.pop(0))] if self._open else []
        self.making_s += process_time() - begun_s
        return ended

    def close(self) -> None:
        pass


def seconds_of(n_scenes: int) -> float:
    """Processor time of a batch of so many."""
    with tempfile.TemporaryDirectory() as scratch:
        folder, engine = Path(scratch), Workers()
        recordings(folder / "scans", **{f"s{n:06d}": 3 + n % 5 for n in range(n_scenes)})
        begun_s = process_time()
        plan, console = BatchPlan.of(RunOptions(), None), PlainConsole(quiet=True)
        batch, _ = begin(
            scenes_of(str(folder / "scans")), Place(str(folder / "out")), plan, lambda: engine, console, resume=False
        )
        batch.run()
        return process_time() - begun_s - engine.making_s


def main(sizes: tuple[int, ...]) -> None:
    """Each batch against the one before."""
    before_s, n_before = seconds_of(1), 1
    for size in sizes:
        took_s = seconds_of(size)
        print(f"{size} scenes: {1e3 * (took_s - before_s) / (size - n_before):.2f} ms a scene", flush=True)
        before_s, n_before = took_s, size


if __name__ == "__main__":
    main(tuple(map(int, sys.argv[1:])) or SIZES)
