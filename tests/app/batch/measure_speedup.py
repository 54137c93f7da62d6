"""What a batch takes beside the same runs one after the other, each held to one core in both arms.

    python -m tests.app.batch.measure_speedup ROOMS [--ray]

Prints one line of JSON: seconds of both arms, the ratio of the batch to half of the serial time, the engine's own share
of the processor time, the processor time of the batch over that of the single runs, which other programs on the machine
change less than seconds, and whether all results are the same to the byte.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from argparse import ArgumentParser
from contextlib import nullcontext
from pathlib import Path
from threading import Event

from app.engines.child_process import run_child
from tests.support.ray_clusters import LoopbackCluster, loopback_cluster

OPTIONS = ("--segmenter=oracle", "--embedder=oracle", "--device=cpu", "--no-timeline")
WITH_TIMES = {"timings.json"}


def serial_s(rooms: Path, out: Path) -> tuple[float, float]:
    """Seconds of `razer run` on each room, one after the other, on one core; and of processors."""
    begun_s, cpu_s = time.monotonic(), 0.0
    for room in sorted(rooms.iterdir()):
        command = [sys.executable, "-m", "app", "run", str(room), "-o", str(out / room.name), *OPTIONS]
        end = run_child(command, out / "log", out / "out", folder="/", cores=1, threads=1, stop=Event())
        assert end.code == 0, (out / "log").read_text()
        cpu_s += end.cpu_s
    return time.monotonic() - begun_s, cpu_s


def batch_s(rooms: Path, out: Path, *placing: str) -> tuple[float, dict]:
    """Seconds of the verb from its call to its end, and its report."""
    begun_s = time.monotonic()
    command = [sys.executable, "-m", "app", "batch", "run", str(rooms), "-o", str(out), *OPTIONS, "--cores=1", *placing]
    subprocess.run([*command, "--workers=2", "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - begun_s, json.loads((out / "report.json").read_text())


def differing(one: Path, other: Path) -> list[str]:
    """Files of runs in one folder that the other has not, or otherwise; times aside."""
    files = [path for run in one.iterdir() if run.is_dir() for path in run.iterdir() if path.name not in WITH_TIMES]
    paths = [path.relative_to(one) for path in files]
    return [str(p) for p in paths if not (other / p).exists() or (one / p).read_bytes() != (other / p).read_bytes()]


def measure(rooms: Path, folder: Path, cluster: LoopbackCluster | None) -> dict:
    """Both arms, and what they say of each other."""
    (folder / "serial").mkdir()
    load_before = os.getloadavg()[0]
    alone_s, alone_cpu_s = serial_s(rooms, folder / "serial")
    load_between, engine_before_s = os.getloadavg()[0], cluster.cpu_s() if cluster else 0.0
    placing = ("--address", cluster.address) if cluster else ()
    together_s, report = batch_s(rooms, folder / "batch", *placing)
    totals = report["totals"]
    engine_s = totals["engine_cpu_s"] + (cluster.cpu_s() - engine_before_s if cluster else 0.0)
    return {
        "engine": "ray" if cluster else "local",
        "scenes": totals["scenes"],
        "done": totals["done"],
        "serial_s": round(alone_s, 1),
        "batch_s": round(together_s, 1),
        "over_half_of_serial": round(together_s / (alone_s / 2), 3),
        "cpu_over_serial": round((engine_s + totals["cpu_s"]) / alone_cpu_s, 3),
        "driver_cpu_s": totals["engine_cpu_s"],
        "daemons_cpu_s": round(engine_s - totals["engine_cpu_s"], 2),
        "scenes_cpu_s": totals["cpu_s"],
        "engine_cpu_share": round(engine_s / (engine_s + totals["cpu_s"]), 4),
        "differing": differing(folder / "serial", folder / "batch"),
        "load": [round(load, 1) for load in (load_before, load_between, os.getloadavg()[0])],
    }


def main() -> None:
    """Measure, and print."""
    parser = ArgumentParser()
    parser.add_argument("rooms", type=Path)
    parser.add_argument("--ray", action="store_true")
    arguments = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        loopback_cluster(3, head_cpus=1) if arguments.ray else nullcontext() as cluster,
    ):
        print(json.dumps(measure(arguments.rooms, Path(folder), cluster)))


if __name__ == "__main__":
    main()
