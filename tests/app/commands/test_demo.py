"""`razer demo` from the outside."""

from __future__ import annotations

import json

import cv2
import numpy as np

from app.pictures.style_colors import HIT
from data_tools.synthetic.synthetic_room import SyntheticRoom
from tests.support.cli import RUN_FILES, listing, razer


def test_demo_names_things_and_surfaces_and_asks(capsys, tmp_path):
    target = tmp_path / "demo"
    code, out, _ = razer(capsys, "demo", "-o", target, "--frames", 8, "--set", "voxels.voxel_size_m=0.05")
    assert code == 0
    assert "simulator" in out
    instances = json.loads((target / "instances.json").read_text())["instances"]
    named = {item["class"] for item in instances}
    assert len(named - {None}) >= 3
    assert named - {None} <= set(SyntheticRoom(n_frames=1, width=16, height=12).classes.values())
    shown = {f"crops/{item['id']:04d}-{view['frame']:06d}.jpg" for item in instances for view in item["best_views"]}
    assert set(listing(target)) == RUN_FILES | {"demo.png", "crops"} | shown
    assert shown
    surfaces = {item["class"] for item in instances if item.get("stuff")}
    assert {"wall", "floor"} <= surfaces <= {"wall", "floor", "ceiling"}
    line = next(line for line in out.splitlines() if line.startswith("surfaces among them (stuff): "))
    assert all(name in line for name in surfaces)
    answer = next(line for line in out.splitlines() if line.startswith('asked for "something to sit on": '))
    assert any(seat in answer for seat in ("chair", "couch"))
    assert "table" not in answer
    assert f"picture: {target / 'demo.png'}" in out
    picture = cv2.imread(str(target / "demo.png")).astype(int)
    assert picture.shape == (694, 2400, 3)
    _, by_name, answer = np.split(picture[54:, :, ::-1], 3, axis=1)
    assert share_of_hits(by_name) < 0.5
    assert share_of_hits(answer) > 0.9  # of the answer nothing but seats is coloured


def share_of_hits(panel):
    """Of the coloured pixels those in the colour of hits, at any brightness."""
    coloured = panel[np.ptp(panel, axis=2) > 60].astype(float)
    assert len(coloured) > 3000
    cosine = coloured @ HIT / np.linalg.norm(HIT) / np.linalg.norm(coloured, axis=1)
    return (cosine > 0.95).mean()
