"""A Chromium that is here, without a graphics card, and what a page did in it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

_FLAGS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
]  # fmt: skip
_WATCH_LONG_TASKS = """
window.longTasks = [];
new PerformanceObserver((list) => window.longTasks.push(...list.getEntries()))
  .observe({ type: "longtask", buffered: true });
"""
READY_MS = 90_000


@dataclass
class OpenPage:
    """A page, what it said on the console that is no plain message, its errors, and the addresses that it asked for."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)

    @property
    def elsewhere(self) -> list[str]:
        """Addresses that are neither in the page itself nor of a local file or server."""
        own = ("file:", "blob:", "data:", "http://127.0.0.1:")
        return [address for address in self.addresses if not address.startswith(own)]


@contextmanager
def chromium() -> Iterator[Any]:
    """The browser; skips the test where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.skip("there is no chromium on this machine")
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=_FLAGS)
        yield browser
        browser.close()


@contextmanager
def opened(
    browser: Any, address: str, width: int = 1366, height: int = 768, theme: str = "light"
) -> Iterator[OpenPage]:
    """A page that shows its map."""
    view = {"width": width, "height": height}
    context = browser.new_context(viewport=view, color_scheme=theme, reduced_motion="reduce", has_touch=width < 500)
    page = context.new_page()
    result = OpenPage(page)
    page.on("console", lambda message: _note(result, message))
    page.on("pageerror", lambda error: result.complaints.append(str(error)))
    page.on("request", lambda request: result.addresses.append(request.url))
    page.add_init_script(_WATCH_LONG_TASKS)
    page.goto(address)
    page.wait_for_selector("body[data-ready]", timeout=READY_MS)
    yield result
    context.close()


def _note(opened_page: OpenPage, message: Any) -> None:
    # What the software renderer says of its own speed is not about the page.
    if message.type in ("error", "warning") and "GPU stall" not in message.text:
        opened_page.complaints.append(message.text)
