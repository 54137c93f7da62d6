"""Figures of the timeline: how soon its page shows something, how large it is, what a run loses to its viewer.

`make timeline-figures` prints them as lines of JSON. Times are of this machine, and only mean something when nothing
else runs on it.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from urllib.error import URLError
from urllib.request import urlopen

import psutil

from app.timeline.entities import SURFACE
from app.timeline.recording.saved_recording import data_of, open_stream
from app.timeline.viewer.free_port import free_port
from app.timeline.viewer.rerun_viewer import server_command
from tests.support.browser import chromium
from tests.support.timeline_page import OF_ONE_RUN, seconds_until_shown, served

SERVER = "app.timeline.viewer.page_server"
OPTIONS = ("--segmenter", "oracle", "--embedder", "oracle", "--overwrite")
READ_BYTES, STARTED_S = 1 << 16, 0.2
Sabotage = Callable[[psutil.Process, Path], list[subprocess.Popen]]


def until_shown_s(run: Path, times: int) -> list[float]:
    """Seconds from asking for the page until both map and curves are drawn, in a fresh page each time."""
    overview = OF_ONE_RUN["Overview"]
    with chromium() as browser, served(run) as address:
        return [seconds_until_shown(browser, address, [overview["map"], overview["curves"]]) for _ in range(times)]


def bytes_of(run: Path, scratch: Path) -> dict[str, float]:
    """KB of the recording for each frame, and without the finished surface, which is there once."""
    timeline = run / "timeline.rrd"
    n_frames = json.loads((run / "timings.json").read_text())["frames"]
    chunks = data_of(timeline).to_chunks()
    stream = open_stream(scratch, "surface")
    stream.send_chunks([chunk for chunk in chunks if chunk.entity_path.lstrip("/") == SURFACE])
    stream.flush()
    stream.disconnect()
    whole, surface = timeline.stat().st_size, scratch.stat().st_size
    scratch.unlink()
    per_frame = {"kb_per_frame": whole / n_frames / 1e3, "kb_without_map": (whole - surface) / n_frames / 1e3}
    return {"frames": n_frames, **{name: round(value, 1) for name, value in per_frame.items()}, "map_mb": surface / 1e6}


def timed_run(recording: Path, target: Path, sabotage: Sabotage | None) -> tuple[float, float]:
    """Wall and CPU seconds of a run with all its processes but the viewer's; with a viewer that has a bad time, or
    without any."""
    viewer = ("--view", "web") if sabotage else ()
    command = [sys.executable, "-m", "app", "run", str(recording), "-o", str(target), *OPTIONS, *viewer]
    start_s = time.monotonic()
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    helpers: list[subprocess.Popen] = []
    server = None
    while sabotage and server is None and run.poll() is None:
        children = psutil.Process(run.pid).children()
        server = next((child for child in children if SERVER in child.cmdline()), None)
        time.sleep(STARTED_S)
    if sabotage and server is not None:
        helpers = sabotage(server, target)
    _, status, usage = os.wait4(run.pid, 0)
    wall_s = time.monotonic() - start_s
    run.returncode = os.waitstatus_to_exitcode(status)
    assert run.returncode == 0
    for process in [*helpers, *([server] if server is not None and server.is_running() else [])]:
        process.kill()
    return wall_s, usage.ru_utime + usage.ru_stime


def stopped(server: psutil.Process, run: Path) -> list[subprocess.Popen]:
    """A reader connects and the server freezes, so that nobody reads any more."""
    read_along(port_of(server))
    time.sleep(1.0)
    server.send_signal(signal.SIGSTOP)
    return []


def killed(server: psutil.Process, run: Path) -> list[subprocess.Popen]:
    """The server dies under its reader."""
    read_along(port_of(server))
    time.sleep(1.0)
    server.kill()
    return []


def reopened(server: psutil.Process, run: Path) -> list[subprocess.Popen]:
    """It dies, and another one is opened and read from the beginning."""
    killed(server, run)
    port = free_port(0)
    again = subprocess.Popen(server_command(run, port))
    read_along(port)
    return [again]


def port_of(server: psutil.Process) -> int:
    """The port that its command line names."""
    return int(server.cmdline()[-2])


def read_along(port: int) -> None:
    """Read all parts of the recording as they grow, in the background, as a browser does."""
    for part in range(3):
        threading.Thread(target=_read, args=(f"http://127.0.0.1:{port}/{part}.rrd",), daemon=True).start()


def _read(address: str) -> None:
    for _ in range(100):
        try:
            with urlopen(address) as part:
                while part.read(READ_BYTES):
                    pass
            return
        except (URLError, ConnectionError):
            time.sleep(STARTED_S)


def slowdowns(recording: Path, target: Path, pairs: int) -> list[dict[str, float | str]]:
    """For each ill of a viewer the medians over pairs of runs with and without it, in turn: wall and CPU time, per cent
    more."""
    found: list[dict[str, float | str]] = []
    for ill in (stopped, killed, reopened):
        measured = [(timed_run(recording, target, None), timed_run(recording, target, ill)) for _ in range(pairs)]
        more = [median(100 * (ill[n] / alone[n] - 1) for alone, ill in measured) for n in range(2)]
        alone_s = median(alone[0] for alone, _ in measured)
        figures = {"wall_percent_more": more[0], "cpu_percent_more": more[1], "alone_s": alone_s}
        found.append({"viewer": ill.__name__, **{name: round(value, 1) for name, value in figures.items()}})
    return found


def main() -> None:
    """Make a recording and a run unless they are there, and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path, help="a folder for the recording and its runs")
    parser.add_argument("runs", type=Path, nargs="*", help="other runs whose page and size are measured, too")
    parser.add_argument("--pairs", type=int, default=3, help="of runs with and without viewer; 0 leaves them out")
    parser.add_argument("--times", type=int, default=3, help="that each page is opened")
    arguments = parser.parse_args()
    work: Path = arguments.work
    work.mkdir(parents=True, exist_ok=True)
    razer = (sys.executable, "-m", "app")
    for name, frames, size in (("room", "120", "640x480"), ("small_room", "80", "320x240")):
        if not (work / name).exists():
            command = [*razer, "synth", work / name, "--frames", frames, "--size", size]
            subprocess.run(command, check=True, stdout=sys.stderr)
    if not (work / "run").exists():
        subprocess.run([*razer, "run", work / "room", "-o", work / "run", *OPTIONS], check=True, stdout=sys.stderr)
    for run in (work / "run", *arguments.runs):
        shown_s = [round(value, 1) for value in until_shown_s(run, arguments.times)]
        load = round(os.getloadavg()[0], 1)
        print(
            json.dumps({"run": str(run), "shown_s": shown_s, "load": load, **bytes_of(run, work / "s.rrd")}), flush=True
        )
    for figures in slowdowns(work / "small_room", work / "timed", arguments.pairs) if arguments.pairs else []:
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
