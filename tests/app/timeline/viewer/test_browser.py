"""The page in a real browser: every tab of a recording opens, without an error and without asking another machine."""

from __future__ import annotations

import subprocess
import time
import urllib.request
from itertools import pairwise

import cv2
import numpy as np
import pytest

from app.timeline.config import TimelineConfig
from app.timeline.rerun_timeline import Timeline
from app.timeline.viewer import rerun_viewer
from app.timeline.viewer.free_port import HOST, free_port
from app.timeline.viewer.rerun_process import rerun_environment
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig, VoxelSettings
from razer.mapper import Mapper
from tests.support.browser import chromium

pytestmark = pytest.mark.full
TABS = {"Objects": (125, 50), "Poses": (205, 50), "Performance": (305, 50)}  # where they lie, pixels
SHOWN_S, LOAD_S = 8.0, 60.0


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Of the page of a small recording."""
    run = tmp_path_factory.mktemp("run")
    room = SyntheticRoom(0, 8, 160, 120)
    mapper = Mapper(MapperConfig(voxels=VoxelSettings(voxel_size_m=0.05)), "oracle", "oracle")
    timeline = Timeline(run / "timeline.rrd", room.intrinsics, TimelineConfig())
    for frame in (room[n] for n in range(len(room))):
        timeline.show(frame, mapper.step(frame), mapper, {"lift": 1.0})
    timeline.finish(mapper.finish())
    timeline.close()
    port = free_port(0)
    server = subprocess.Popen(rerun_viewer.server_command(run, port), env=rerun_environment())
    place = f"http://{HOST}:{port}/"
    wait_for(place)
    yield place
    server.kill()
    server.wait()


def wait_for(address, patience_s=60.0):
    """Until something answers there."""
    end_s = time.monotonic() + patience_s
    while True:
        try:
            return urllib.request.urlopen(address, timeout=5).close()
        except OSError:
            assert time.monotonic() < end_s, f"nothing answers at {address}"
            time.sleep(0.2)


def test_every_tab_opens_without_errors_and_without_the_network(address, tmp_path):
    errors, elsewhere, shots = [], [], []
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: request.url.startswith(address) or elsewhere.append(request.url))
        page.goto(address)
        page.wait_for_timeout(1000 * LOAD_S)
        for name, place in [("Overview", (40, 50)), *TABS.items()]:
            page.mouse.click(*place)
            page.wait_for_timeout(1000 * SHOWN_S)
            page.screenshot(path=tmp_path / f"{name}.png", timeout=120_000)
            shots.append(cv2.imread(str(tmp_path / f"{name}.png")))
    assert errors == []
    assert [url for url in elsewhere if not url.startswith(("data:", "blob:"))] == []
    for shot in shots:
        assert (shot[100:800] < 200).any(axis=2).mean() > 0.005  # something is drawn
    for one, other in pairwise(shots):
        assert np.abs(one.astype(int) - other).mean() > 0.5
