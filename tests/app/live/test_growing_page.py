"""The page of a map that grows, in a real browser before a real run."""

from __future__ import annotations

import time

import cv2
import numpy as np
import pytest

from razer.saved_map import load_map
from tests.support.browser import chromium, opened
from tests.support.served_runs import served_run

pytestmark = pytest.mark.full
SLOWLY = ("--set", "voxels.voxel_size_m=0.015")  # so that there is something left to grow once the page is open


def counted(page) -> int:
    return int(page.locator("#count").text_content().split()[0])


def of_map(page, tmp_path) -> float:
    """The share of the picture that is not its empty, all but even background."""
    page.locator("#view").screenshot(path=tmp_path / "view.png")
    image = cv2.imread(str(tmp_path / "view.png"))[80:-120, :-360].astype(int)
    return float((np.abs(image - image[0, 0]).max(axis=2) > 60).mean())


def test_the_page_shows_a_run_grow_and_ends_with_what_is_saved(recording, tmp_path):
    out = tmp_path / "run"
    with chromium() as browser, served_run(recording, out, *SLOWLY) as run, opened(browser, run.address) as seen:
        page, first = seen.page, counted(seen.page)
        assert not out.exists(), "the run was over before it was looked at"
        shares, counts = [], []
        while not out.exists():
            time.sleep(0.5)
            counts.append(counted(page))
            shares.append(of_map(page, tmp_path))
        run.until("serving the finished map")
        saved = load_map(out)
        page.locator("#count", has_text=f"{len(saved.objects)} instances").wait_for(timeout=60_000)
        assert max(counts) > first
        assert of_map(page, tmp_path) > 0.2
        assert max(shares) > 0.2
        thing = max((o for o in saved.objects if not o.is_stuff), key=lambda o: o.n_vertices)
        page.get_by_role("button", name=f"{thing.class_name} {thing.id}").first.click()
        page.locator("#card h2", has_text=thing.class_name).wait_for()
        assert (seen.complaints, seen.elsewhere) == ([], [])
