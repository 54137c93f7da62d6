"""`razer demo` from the outside."""

from __future__ import annotations

import json

from data_tools.synthetic.synthetic_room import SyntheticRoom
from tests.support.cli import RUN_FILES, listing, razer


def test_demo_names_things_of_the_simulated_room(capsys, tmp_path):
    target = tmp_path / "demo"
    code, out, _ = razer(capsys, "demo", "-o", target, "--frames", 8, "--set", "voxels.voxel_size_m=0.05")
    assert code == 0
    assert "simulator" in out
    named = {item["class"] for item in json.loads((target / "instances.json").read_text())["instances"]}
    assert len(named - {None}) >= 3
    assert named - {None} <= set(SyntheticRoom(n_frames=1, width=16, height=12).classes.values())
    assert set(listing(target)) == RUN_FILES
    answer = next(line for line in out.splitlines() if line.startswith('asked for "something to sit on": '))
    assert any(seat in answer for seat in ("chair", "couch"))
    assert "table" not in answer
