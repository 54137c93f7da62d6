"""The animation at the head of the README: a question is typed on the served page of the demo, what answers it lights
up, and one of the hits is visited. `make animation` writes docs/query.webp."""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

QUESTION = "something to sit on"
VISITED = "couch"
SIZE = {"width": 1080, "height": 620}
SCALE = 0.7  # of what is shown in the README
QUALITY = 72
FRAME_MS, HOLD_MS = 80, 1400
FLIGHT_PICTURES = 20
SLOWER = 10  # while the camera flies: a picture takes longer than a frame
OPEN_MS, ANSWER_MS, SETTLE_MS = 60_000, 20_000, 2_500
SLOW_MOTION = """
const now = performance.now.bind(performance), frame = requestAnimationFrame.bind(window);
let shown = 0, since = 0, rate = 1;
performance.now = () => shown + (now() - since) * rate;
window.slowTo = (to) => { shown = performance.now(); since = now(); rate = to; };
window.requestAnimationFrame = (step) => frame(() => step(performance.now()));
"""
CHROMIUM = (
    "--no-sandbox",
    "--disable-quic",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)


@contextmanager
def served(run: Path) -> Iterator[str]:
    """The address at which a run is served meanwhile."""
    command = [sys.executable, "-m", "app", "serve", str(run), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as server:
        try:
            assert server.stdout is not None
            address = next(found[0] for line in server.stdout if (found := re.search(r"http://\S+", line)))
            yield address
        finally:
            server.terminate()


@dataclass
class Film:
    """Pictures of a page and how long each is shown, milliseconds."""

    page: Page
    pictures: list[Image.Image] = field(default_factory=list)
    durations_ms: list[int] = field(default_factory=list)

    def shoot(self, duration_ms: int) -> None:
        """One more picture."""
        picture = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
        size = (round(picture.width * SCALE), round(picture.height * SCALE))
        self.pictures.append(picture.resize(size, Image.Resampling.LANCZOS))
        self.durations_ms.append(duration_ms)

    def save(self, path: Path) -> None:
        """Write them as an animated WebP that starts over at its end."""
        first, *others = self.pictures
        first.save(
            path, save_all=True, append_images=others, duration=self.durations_ms, loop=0, quality=QUALITY, method=4
        )


def film(page: Page, address: str) -> Film:
    """The question, what answers it, and a visit."""
    film = Film(page)
    page.add_init_script(SLOW_MOTION)
    page.goto(address)
    page.get_by_role("button", name=re.compile(r"^chair 6")).first.wait_for(timeout=OPEN_MS)
    page.wait_for_timeout(SETTLE_MS)
    film.shoot(HOLD_MS)
    search = page.get_by_role("searchbox").first
    search.click()
    search.press_sequentially(QUESTION)
    search.press("Enter")
    page.get_by_text("instances in this map").first.wait_for(timeout=ANSWER_MS)
    page.wait_for_timeout(SETTLE_MS)
    film.shoot(2 * HOLD_MS)
    page.evaluate(f"slowTo({1 / SLOWER})")
    page.get_by_role("button", name=re.compile(rf"^{VISITED}")).first.click()
    shown_ms = page.evaluate("performance.now()")
    for _ in range(FLIGHT_PICTURES):
        before_ms, shown_ms = shown_ms, page.evaluate("performance.now()")
        film.shoot(max(FRAME_MS, round(shown_ms - before_ms)))
    page.evaluate("slowTo(1)")
    page.wait_for_timeout(SETTLE_MS)
    film.shoot(2 * HOLD_MS)
    return film


def main() -> None:
    """Write the animation of a run that `razer demo` made."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/query.webp"))
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    arguments = parser.parse_args()
    with served(arguments.run) as address, sync_playwright() as browsers:
        browser = browsers.chromium.launch(executable_path=arguments.chromium, args=[*CHROMIUM])
        made = film(browser.new_page(viewport=SIZE, color_scheme="light"), address)
        browser.close()
    made.save(arguments.out)
    print(f"{arguments.out}: {len(made.pictures)} pictures, {arguments.out.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
