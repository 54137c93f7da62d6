"""Rerun's page of a recording in a Chromium: its tabs, and how much is drawn in each of their panels."""

from __future__ import annotations

import base64
import subprocess
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from app.timeline.viewer import rerun_viewer
from app.timeline.viewer.free_port import HOST, free_port
from app.timeline.viewer.rerun_process import rerun_environment
from razer.arrays import Uint8Array

SIZE = {"width": 1400, "height": 900}
TABS = {"Overview": (40, 50), "Objects": (125, 50), "Poses": (205, 50), "Performance": (305, 50)}  # where they lie
Panel = tuple[int, int, int, int]  # left, top, right, bottom: pixels of what lies within its frame
MAP, CARD, CURVES = (4, 95, 830, 860), (845, 465, 1390, 715), (870, 756, 1390, 852)
OF_ONE_RUN: dict[str, dict[str, Panel]] = {
    "Overview": {"map": MAP, "image": (845, 95, 1390, 425), "card": CARD, "curves": CURVES},
    "Objects": {"map": (4, 95, 690, 560), "best views": (4, 590, 690, 860), "lives": (705, 95, 1390, 860)},
    "Poses": {"map": (4, 95, 690, 860)},
    "Performance": {"stages": (45, 95, 1215, 525), "legend": (1230, 95, 1390, 530), "memory": (45, 600, 460, 845)},
}
OF_TWO_RUNS: dict[str, dict[str, Panel]] = {
    "Overview": {"first map": (4, 95, 690, 540), "second map": (710, 95, 1390, 540)},
    "Objects": {"first": (4, 95, 690, 860), "second": (710, 95, 1390, 860)},
    "Poses": {"paths": MAP, "which": (845, 95, 1390, 460), "curves": (870, 500, 1390, 850)},
    "Performance": {"first": (45, 95, 690, 845), "second": (745, 95, 1390, 845)},
}
LEAST_INK = {"map": 0.05, "first map": 0.05, "second map": 0.05, "image": 0.2}
LEAST_INK_ELSEWHERE = 0.002  # letters and thin curves
WHITE = 200  # and lighter is paper, or the grid of a plot
CALM = 0.02  # mean difference of pixels between two pictures of a page that stands still
PATIENCE_S, POLL_MS = 120.0, 300


@contextmanager
def served(place: Path) -> Iterator[str]:
    """The address at which the recordings of a run are served meanwhile."""
    port = free_port(0)
    server = subprocess.Popen(rerun_viewer.server_command(place, port), env=rerun_environment())
    address = f"http://{HOST}:{port}/"
    try:
        wait_for(address)
        yield address
    finally:
        server.kill()
        server.wait()


def wait_for(address: str, patience_s: float = 60.0) -> None:
    """Until something answers there."""
    end_s = time.monotonic() + patience_s
    while True:
        try:
            return urllib.request.urlopen(address, timeout=5).close()
        except OSError:
            if time.monotonic() > end_s:
                raise
            time.sleep(0.2)


@dataclass
class TimelinePage:
    """A page on a recording, its errors, and the addresses that it asked for."""

    page: Any
    errors: list[str] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)

    def open_tab(self, name: str, panels: dict[str, Panel]) -> Uint8Array:
        """The page (H, W, 3), BGR, once all panels of a tab show something and nothing moves any more; as it is when
        that takes too long."""
        self.page.mouse.click(*TABS[name])
        end_s = time.monotonic() + PATIENCE_S
        picture = self._shoot()
        while time.monotonic() < end_s:
            self.page.wait_for_timeout(POLL_MS)
            before, picture = picture, self._shoot()
            if not blank_panels(picture, panels) and np.abs(picture.astype(int) - before).mean() < CALM:
                break
        return picture

    def _shoot(self) -> Uint8Array:
        return _decoded(self.page.screenshot(timeout=1000 * PATIENCE_S))


@contextmanager
def opened(browser: Any, address: str) -> Iterator[TimelinePage]:
    """A fresh page that was just sent there."""
    context = browser.new_context(viewport=SIZE, color_scheme="light")
    result = TimelinePage(context.new_page())
    result.page.on("console", lambda message: message.type == "error" and result.errors.append(message.text))
    result.page.on("pageerror", lambda error: result.errors.append(str(error)))
    result.page.on("request", lambda request: result.addresses.append(request.url))
    result.page.goto(address)
    yield result
    context.close()


def seconds_until_shown(browser: Any, address: str, panels: Sequence[Panel], patience_s: float = PATIENCE_S) -> float:
    """From asking for a page until something is drawn in all panels, by the browser's own pictures of it."""
    context = browser.new_context(viewport=SIZE, color_scheme="light")
    page = context.new_page()
    cast = context.new_cdp_session(page)
    shown_s: list[float] = []

    def look(event: dict[str, Any]) -> None:
        picture = _decoded(base64.b64decode(event["data"]))
        if not shown_s and all(ink(picture, panel) > LEAST_INK_ELSEWHERE for panel in panels):
            shown_s.append(event["metadata"]["timestamp"])
        cast.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

    cast.on("Page.screencastFrame", look)
    cast.send("Page.startScreencast", {"format": "jpeg", "quality": 80})
    start_s = time.time()
    page.goto(address, wait_until="commit")
    while not shown_s and time.time() - start_s < patience_s:
        page.wait_for_timeout(100)
    context.close()
    return shown_s[0] - start_s if shown_s else float("inf")


def blank_panels(picture: Uint8Array, panels: dict[str, Panel]) -> list[str]:
    """The names of those in which less is drawn than there has to be."""
    least = {name: LEAST_INK.get(name, LEAST_INK_ELSEWHERE) for name in panels}
    return [name for name, panel in panels.items() if ink(picture, panel) < least[name]]


def ink(picture: Uint8Array, panel: Panel) -> float:
    """The share of the pixels of a panel that are not paper."""
    left, top, right, bottom = panel
    return float((picture[top:bottom, left:right] < WHITE).any(axis=2).mean())


def _decoded(encoded: bytes) -> Uint8Array:
    return cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR).astype(np.uint8)
