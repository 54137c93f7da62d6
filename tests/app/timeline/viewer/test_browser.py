"""The page in a real browser: every tab of three recordings shows what it should, without an error and without asking
another machine. RAZER_SCREENSHOTS names a folder that keeps the pictures."""

from __future__ import annotations

import os
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.support.browser import chromium
from tests.support.cli import QUICK, call
from tests.support.timeline_page import (
    OF_ONE_RUN,
    OF_TWO_RUNS,
    SIZE,
    TABS,
    blank_panels,
    ink,
    opened,
    seconds_until_shown,
    served,
)

pytestmark = pytest.mark.full
GEOMETRIC = ("--segmenter", "geometric", "--embedder", "appearance", *QUICK)
FRAMES, SIZE_OF_IMAGES = "40", "320x240"


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    recording = tmp_path_factory.mktemp("recording") / "room"
    assert call("synth", recording, "--frames", FRAMES, "--size", SIZE_OF_IMAGES) == 0
    return recording


@pytest.fixture(params=["estimated", "given", "both"])
def run(request, tmp_path, room):
    """A finished run: a simulated room with estimated poses, a stretch of a real kitchen with given ones, or two."""
    recording, options = room, ["--poses", {"estimated": "slam"}.get(request.param, request.param)]
    if request.param == "given":
        recording, options = request.getfixturevalue("real_data") / "redkitchen", [*options, "--end", "40"]
    assert call("run", recording, "-o", tmp_path / request.param, *options, *GEOMETRIC) == 0
    return tmp_path / request.param


def test_every_tab_shows_its_panels_without_errors_and_without_the_network(run, tmp_path):
    kept = Path(os.environ.get("RAZER_SCREENSHOTS", tmp_path))
    kept.mkdir(parents=True, exist_ok=True)
    layout = OF_TWO_RUNS if run.name == "both" else OF_ONE_RUN
    pictures, blank = [], {}
    with chromium() as browser, served(run) as address, opened(browser, address) as page:
        for tab in TABS:
            pictures.append(page.open_tab(tab, layout[tab]))
            cv2.imwrite(str(kept / f"{run.name}_{tab.lower()}.png"), pictures[-1])
            blank[tab] = blank_panels(pictures[-1], layout[tab])
        elsewhere = [url for url in page.addresses if not url.startswith((address, "data:", "blob:"))]
        assert (page.errors, elsewhere) == ([], [])
    assert blank == {tab: [] for tab in TABS}
    for one, other in pairwise(pictures):
        assert np.abs(one.astype(int) - other).mean() > 0.5


def test_an_empty_page_is_seen_to_be_blank_and_never_counts_as_shown(tmp_path):
    page = tmp_path / "empty.html"
    page.write_text("<title>nothing</title>")
    paper = np.full((SIZE["height"], SIZE["width"], 3), 250, np.uint8)
    for panels in (*OF_ONE_RUN.values(), *OF_TWO_RUNS.values()):
        assert blank_panels(paper, panels) == list(panels)
        assert all(ink(paper, panel) == 0 for panel in panels.values())
    with chromium() as browser:
        shown_s = seconds_until_shown(browser, page.as_uri(), [OF_ONE_RUN["Overview"]["map"]], patience_s=3)
    assert shown_s == float("inf")
