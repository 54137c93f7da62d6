"""`razer run --serve`: the map answers while it grows; whoever looks on can neither end nor hold up the run."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress

import httpx
import psutil
import pytest

from app.page.packet import unpack
from razer.saved_map import load_map
from tests.support.cli import QUICK, contents
from tests.support.served_runs import MODELS, a_named_thing, served_run

pytestmark = pytest.mark.full
_LISTENS = """
import httpx, time
with httpx.stream("GET", "{address}api/v1/events") as response:
    next(response.iter_raw())
    print("listening", flush=True)
    time.sleep(100)
"""


def test_the_map_answers_while_it_grows_and_when_it_is_done(recording, tmp_path):
    out = tmp_path / "run"
    with served_run(recording, out) as run:
        heard: list[str] = []

        def listen() -> None:
            with suppress(httpx.HTTPError), httpx.stream("GET", f"{run.address}api/v1/events", timeout=60) as response:
                heard.extend(response.iter_lines())

        threading.Thread(target=listen, daemon=True).start()
        thing = a_named_thing(run)
        assert not out.exists()
        answer = run.post("query", {"text": thing["name"]}).json()
        assert thing["name"] in {hit["name"] for hit in answer["hits"]}
        assert "not in this map" in run.post("query", {"text": "piano"}).json()["statement"]
        header, _ = unpack(run.get("page").content)
        assert header["growing"]
        blocks, _ = unpack(run.get("mesh/changes?since=0").content)
        assert sum(block["triangles"] for block in blocks["blocks"]) > 0
        later, _ = unpack(run.get(f"mesh/changes?since={blocks['revision']}").content)
        assert later["revision"] >= blocks["revision"]

        run.until("serving the finished map")
        assert run.get("mesh/changes?since=0").status_code in (200, 404)  # until the map of the folder is open
        deadline_s = time.monotonic() + 30
        while run.get("mesh/changes?since=0").status_code == 200 and time.monotonic() < deadline_s:
            time.sleep(0.2)
        saved = load_map(out)
        listed = run.get("instances?limit=1000").json()
        assert {entry["id"] for entry in listed["instances"]} == {o.id for o in (*saved.objects, *saved.parts)}
        run.process.send_signal(signal.SIGINT)
        started_s = time.monotonic()
        assert run.process.wait(10) == 0
        assert time.monotonic() - started_s < 10  # of two programs that end; the server alone has its own test
        told = [json.loads(line.removeprefix("data: ")) for line in heard if line.startswith("data: ")]
        revisions = [event["revision"] for event in told if "revision" in event]
        assert revisions
        assert revisions == sorted(revisions)
        assert {"kind": "finished", "author": ""}.items() <= told[-1].items()


def test_edits_of_a_growing_map_stay_with_their_instances_to_the_end(recording, tmp_path):
    out = tmp_path / "run"
    with served_run(recording, out) as run:
        thing = a_named_thing(run)
        edit = {"kind": "rename", "epoch": 0, "author": "Ada", "instance": thing["id"], "name": "zeppelin"}
        made = run.post("edits", edit)
        assert made.status_code == 201, made.text
        late = run.post("edits", {**edit, "author": "Bob", "name": "balloon"})
        assert (late.status_code, late.json()["type"]) == (409, "stale")
        run.until("serving the finished map")
        named = [o for o in load_map(out).objects if o.class_name == "zeppelin"]
        assert len(named) == 1
        gap_m = abs(named[0].box.center - thing["center_m"]).max()
        assert gap_m < 0.5
        assert [hit["id"] for hit in run.post("query", {"text": "zeppelin"}).json()["hits"]] == [named[0].id]


def test_clients_that_are_killed_or_never_read_change_nothing(recording, tmp_path):
    plain = tmp_path / "plain"
    command = [sys.executable, "-m", "app", "run", recording, "-o", plain, *MODELS, *QUICK, "--no-timeline"]
    subprocess.run([*map(str, command)], check=True, capture_output=True)
    with served_run(recording, tmp_path / "run") as run:
        script = _LISTENS.format(address=run.address)
        viewers = [subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) for _ in range(3)]
        for viewer in viewers[:2]:
            viewer.stdout.readline()
            os.kill(viewer.pid, signal.SIGKILL)
        run.until("serving the finished map")
        for viewer in viewers:
            viewer.kill()
            viewer.wait()
    same = ("instances.json", "mesh.ply", "map.npz", "embeddings.npz", "trajectory.txt")
    one, other = contents(plain), contents(tmp_path / "run")
    assert {name: one[name] == other[name] for name in same} == dict.fromkeys(same, True)


def test_the_run_goes_on_when_the_server_is_killed(recording, tmp_path):
    with served_run(recording, tmp_path / "run") as run:
        a_named_thing(run)
        host, port = re.search(r"//([\d.]+):(\d+)", run.address).groups()
        children = psutil.Process(run.process.pid).children(recursive=True)
        (server,) = [c for c in children if any(s.laddr == (host, int(port)) for s in c.net_connections())]
        server.kill()
        assert run.process.wait(120) == 0
        assert any("server ended" in line for line in run.lines)
    assert load_map(tmp_path / "run").objects


def test_the_server_ends_with_its_run_when_that_is_killed(recording, tmp_path):
    with served_run(recording, tmp_path / "run") as run:
        a_named_thing(run)
        children = psutil.Process(run.process.pid).children(recursive=True)
        run.process.kill()
        _, alive = psutil.wait_procs(children, timeout=10)
        assert not alive


def test_ctrl_c_during_the_run_keeps_what_was_mapped_and_ends_the_server(recording, tmp_path):
    with served_run(recording, tmp_path / "run") as run:
        a_named_thing(run)
        run.process.send_signal(signal.SIGINT)
        assert run.process.wait(60) == 130
    assert load_map(tmp_path / "run").objects
