"""Whole batches on both engines: results as of single runs, through deaths, interruptions and broken stores."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import pytest

from app.object_store.place import Place
from app.object_store.publishing import publish, read_text
from app.object_store.staging import staged
from tests.support.cli import QUICK, environment, write_small_room
from tests.support.faulty_store import BUCKET, SECRET, faulty_store

OPTIONS = ("--segmenter", "geometric", "--embedder", "appearance", "--no-timeline", *QUICK)
OWN_TO_A_RUN = {"timings.json", "published.json"}
pytestmark = pytest.mark.full


@pytest.fixture(scope="module")
def rooms(tmp_path_factory) -> Path:
    """Three rooms, and a recording that cannot be opened."""
    folder = tmp_path_factory.mktemp("rooms")
    for name, n_frames in {"a": 6, "b": 9, "c": 12}.items():
        write_small_room(folder / name, n_frames=n_frames)
    for name in ("color", "depth"):
        (folder / "poison" / name).mkdir(parents=True)
    (folder / "poison" / "intrinsics.json").write_text("{}")
    return folder


@pytest.fixture(scope="module")
def alone(rooms, tmp_path_factory) -> Path:
    """What `razer run` makes of each room."""
    folder = tmp_path_factory.mktemp("alone")
    for name in "abc":
        command = [sys.executable, "-m", "app", "run", rooms / name, "-o", folder / name, *OPTIONS]
        subprocess.run(command, check=True, capture_output=True, env=environment())
    return folder


def start(scenes: object, out: object, *options: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "app", "batch", "run", str(scenes), "-o", str(out), *OPTIONS, *map(str, options)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment(), start_new_session=True
    )


def finish(process: subprocess.Popen[str], code: int) -> str:
    said, _ = process.communicate(timeout=550)
    assert process.returncode == code, said
    return said


def results(folder: Path, *, with_config: bool = True) -> dict[str, bytes]:
    left_out = OWN_TO_A_RUN if with_config else OWN_TO_A_RUN | {"config.toml"}
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name not in left_out and path.is_file()}


def assert_only_poison_failed(report: dict) -> None:
    by_name = {entry["name"]: entry for entry in report["scenes"]}
    assert {name: entry["status"] for name, entry in by_name.items()} == {
        "a": "done",
        "b": "done",
        "c": "done",
        "poison": "failed",
    }
    assert by_name["poison"]["attempts"] == 1
    assert "intrinsics.json" in by_name["poison"]["reason"]
    assert all(entry["cpu_s"] > 0 and entry["peak_mb"] > 100 for entry in by_name.values())


def running(recording: Path) -> list[psutil.Process]:
    """The processes that map a recording, without their helpers."""
    found = []
    for process in psutil.process_iter(["cmdline"]):
        words = process.info["cmdline"] or []
        if words[1:4] == ["-m", "app", "run"] and str(recording) in words:
            found.append(process)
    return found


def wait_for_run(recording: Path) -> psutil.Process:
    deadline_s = time.monotonic() + 200
    while not (found := running(recording)):
        assert time.monotonic() < deadline_s
        time.sleep(0.05)
    return found[0]


def test_results_are_those_of_single_runs_and_are_evaluated(rooms, alone, tmp_path):
    said = finish(start(rooms, tmp_path / "out", "--workers", 2, "--eval", "default"), 1)
    assert_only_poison_failed(json.loads((tmp_path / "out/report.json").read_text()))
    for name in "abc":
        assert results(tmp_path / "out" / name) == results(alone / name)
    assert "a is not evaluated: the recording has no truth" in said
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a", "b", "batch_logs", "c", "report.json"]


def test_a_run_that_is_killed_is_tried_again_and_ctrl_c_loses_nothing(rooms, alone, tmp_path):
    """The longest comes first and is killed, as by a system without memory; Ctrl-C comes during the second."""
    out = tmp_path / "out"
    process = start(rooms, out, "--workers", 1, "--checkpoint-every", 3)
    wait_for_run(rooms / "c").kill()
    deadline_s = time.monotonic() + 200
    while not (out / "c").exists():
        assert time.monotonic() < deadline_s
        time.sleep(0.05)
    wait_for_run(rooms / "b")
    while not list((out / ".unfinished").glob(".b.partial-*/checkpoint/checkpoint.json")):
        assert time.monotonic() < deadline_s
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    finish(process, 130)
    assert running(rooms / "b") == []
    report = {entry["name"]: entry for entry in json.loads((out / "report.json").read_text())["scenes"]}
    assert [report[name]["status"] for name in "abc"] == ["unfinished", "unfinished", "done"]
    assert report["c"]["attempts"] == 2
    assert "killed" in report["c"]["history"][0]["reason"]
    finish(start(rooms, out, "--workers", 1, "--checkpoint-every", 3, "--resume"), 1)
    assert_only_poison_failed(json.loads((out / "report.json").read_text()))
    assert json.loads((out / "b/timings.json").read_text())["resumed_at"]
    for name in "abc":
        assert results(out / name, with_config=False) == results(alone / name, with_config=False)


@contextmanager
def ray_cluster() -> Iterator[tuple[str, list]]:
    """Four nodes on this machine, each a raylet of its own, for one scene each; the head has no CPUs."""
    from ray.cluster_utils import Cluster

    environment_before = dict(os.environ)
    os.environ.update(environment())
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    try:
        own = {"num_cpus": 2, "memory": 6_000_000_000, "object_store_memory": 80_000_000}
        nodes = [cluster.add_node(**own) for _ in range(4)]
        cluster.wait_for_nodes(120)
        yield cluster.address, nodes
    finally:
        cluster.shutdown()
        os.environ.clear()
        os.environ.update(environment_before)


def raylet_of(process: psutil.Process, nodes: list) -> psutil.Process:
    raylets = {node.all_processes["raylet"][0].process.pid for node in nodes}
    return next(parent for parent in process.parents() if parent.pid in raylets)


def power_cut(raylet: psutil.Process) -> None:
    """End a node with its workers; their runs end by themselves. A raylet alone is not missed by a worker that has
    work: its scene may be mapped all the same."""
    workers = [one for one in raylet.children(recursive=True) if "app" not in one.cmdline()]
    for process in (raylet, *workers):
        with suppress(psutil.NoSuchProcess):
            process.kill()


def test_every_scene_but_the_poisoned_one_has_its_result_through_deaths(rooms, alone, tmp_path):
    """A node is lost while it maps a scene, and a run on another one killed as by a system without memory."""
    out = tmp_path / "out"
    with ray_cluster() as (address, nodes):
        process = start(rooms, out, "--address", address, "--workers", 2)
        mapping = wait_for_run(rooms / "c")
        wait_for_run(rooms / "b").kill()
        power_cut(raylet_of(mapping, nodes))
        finish(process, 1)
        with suppress(psutil.NoSuchProcess):
            assert not mapping.is_running() or mapping.status() == psutil.STATUS_ZOMBIE  # it ended with its node
    report = json.loads((out / "report.json").read_text())
    assert_only_poison_failed(report)
    history = {entry["name"]: [one["reason"] for one in entry["history"]] for entry in report["scenes"]}
    assert len(history["c"]) == 2
    assert "lost" in history["c"][0]
    assert len(history["b"]) == 2
    assert "killed by the system" in history["b"][0]
    for name in "abc":
        assert results(out / name) == results(alone / name)
    assert sorted(path.name for path in out.iterdir()) == ["a", "b", "batch_logs", "c", "report.json"]


def test_scenes_of_a_broken_store_become_maps_there(rooms, alone, tmp_path, monkeypatch):
    monkeypatch.setenv("RAZER_STAGING", str(tmp_path / "staging"))
    with faulty_store(monkeypatch, throttled=0.06, failed=0.04, refused=0.04, cut=0.04) as store:
        for name in "ab":
            publish(rooms / name, Place.of(f"s3://{BUCKET}/scans/{name}"))
        out = Place.of(f"s3://{BUCKET}/maps")
        said = finish(start(f"s3://{BUCKET}/scans", out, "--workers", 2), 0)
        report = json.loads(read_text(out / "report.json") or "")
        assert {entry["name"]: entry["status"] for entry in report["scenes"]} == {"a": "done", "b": "done"}
        for name in "ab":
            assert results(staged(out / name), with_config=False) == results(alone / name, with_config=False)
            log = read_text(out / "batch_logs" / f"{name}.1.log")
            assert log
            assert SECRET not in log + said
        assert min(store.faults.met.values()) > 0
    assert list((tmp_path / "staging" / "inputs").iterdir()) == [] or not any(
        path.name in ("color", "depth") for path in (tmp_path / "staging" / "inputs").rglob("*")
    )
