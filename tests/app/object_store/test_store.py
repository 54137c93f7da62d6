"""Staging and publishing against a store with the interface of S3 on loopback, which throttles, fails, breaks off."""

from __future__ import annotations

import json
import os
from pathlib import Path

import fsspec
import numpy as np
import pytest

from app.object_store import attempts
from app.object_store.place import Place
from app.object_store.publishing import is_published, publish, read_text, write_text
from app.object_store.staging import forget, sizes, staged
from razer.errors import BadInput
from tests.support.cli import contents
from tests.support.faulty_store import BUCKET, SECRET, faulty_store

FAULTS = {"throttled": 0.08, "failed": 0.05, "refused": 0.05, "cut": 0.05}


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path):
    monkeypatch.setenv("RAZER_STAGING", str(tmp_path / "staging"))
    monkeypatch.setattr(attempts, "_FIRST_WAIT_S", 0.01)
    fsspec.filesystem("s3", skip_instance_cache=True).clear_instance_cache()


def some_files(folder: Path, count: int) -> dict[str, bytes]:
    random = np.random.default_rng(3)
    for index in range(count):
        path = folder / ("color" if index % 2 else "depth/deep") / f"{index:03d} é.bin"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(random.bytes(1 + 3000 * index))
    (folder / "empty.txt").write_bytes(b"")
    return contents(folder)


@pytest.mark.full
def test_what_is_published_is_staged_whole_through_all_faults(monkeypatch, tmp_path):
    given = some_files(tmp_path / "run", 40)
    with faulty_store(monkeypatch, **FAULTS) as store:
        place = Place.of(f"s3://{BUCKET}/maps/kitchen")
        assert not is_published(place)
        publish(tmp_path / "run", place)
        assert is_published(place)
        there = staged(place)
        manifest = json.loads((there / "published.json").read_text())
        assert manifest["files"] == {name: len(content) for name, content in given.items()}
        assert {name: data for name, data in contents(there).items() if name != "published.json"} == given
        assert set(sizes(Place.of(f"s3://{BUCKET}/maps"))) == {f"kitchen/{name}" for name in (*given, "published.json")}
        assert min(store.faults.met[kind] for kind in FAULTS) > 0, store.faults.met


@pytest.mark.full
def test_a_recording_is_fetched_once_and_forgotten(monkeypatch, tmp_path):
    given = some_files(tmp_path / "scan", 5)
    with faulty_store(monkeypatch) as store:
        place = Place.of(f"s3://{BUCKET}/scans/a")
        publish(tmp_path / "scan", place)
        first = staged(place)
        store.faults.share["failed"] = 1.0  # whoever asks the store now is refused
        assert staged(place) == first
        assert contents(first).keys() == {*given, "published.json"}
        forget(place)
        assert not first.exists()


@pytest.mark.full
def test_nothing_counts_as_published_before_all_is_there(monkeypatch, tmp_path):
    some_files(tmp_path / "run", 6)
    with faulty_store(monkeypatch) as store:
        place = Place.of(f"s3://{BUCKET}/others/b")
        monkeypatch.setattr(attempts, "_ATTEMPTS", 1)
        real, copied = attempts.persistently, []
        monkeypatch.setattr("app.object_store.publishing._copy", lambda *_: copied.append(1) or real(_fail, "copying"))
        with pytest.raises(BadInput, match="copying"):
            publish(tmp_path / "run", place)
        assert copied
        assert not is_published(place)
        assert sizes(Place.of(f"s3://{BUCKET}/others")) == {}
        assert store.faults.met == {}


def _fail() -> None:
    raise OSError("the store went away")


@pytest.mark.full
def test_refusals_are_a_line_without_keys(monkeypatch, tmp_path):
    monkeypatch.setattr(attempts, "_ATTEMPTS", 2)
    with faulty_store(monkeypatch), pytest.raises(BadInput) as caught:
        staged(Place.of(f"s3://{BUCKET}/nowhere"))
    assert "does not exist" in str(caught.value)
    with faulty_store(monkeypatch), pytest.raises(BadInput) as caught:
        write_text(Place.of("s3://no-such-bucket/x"), "text")
    assert SECRET not in str(caught.value)
    assert "no-such-bucket/x cannot be written" in str(caught.value)


def test_places_of_this_machine_need_no_store(tmp_path):
    place = Place.of(f"file://{tmp_path}/a%20b/")
    assert (place.path, place.name, place.is_remote) == (tmp_path / "a b", "a b", False)
    assert Place.of(os.curdir).path == Path.cwd()
    assert read_text(place / "x") is None
    place.path.mkdir()
    write_text(place / "x", "text")
    assert read_text(place / "x") == "text"
    assert staged(place) == place.path
    (place.path / "y").write_bytes(b"\xff\xfe")
    with pytest.raises(BadInput, match="no UTF-8 text"):
        read_text(place / "y")


def test_a_store_in_memory_is_staged_and_bad_names_lead_nowhere(tmp_path):
    store = fsspec.filesystem("memory")
    store.pipe_file("/lab/scan/color/0.png", b"abc")
    place = Place.of("memory://lab/scan")
    assert contents(staged(place)) == {"color/0.png": b"abc"}
    assert not place.is_tried
    store.pipe_file("/lab/report.json", b"\xff\xfe")
    with pytest.raises(BadInput, match="no UTF-8 text"):
        read_text(Place.of("memory://lab/report.json"))
    with pytest.raises(BadInput, match="does not exist"):
        staged(Place.of("memory://lab/none"))


def test_attempts_end(monkeypatch):
    tried = []

    def fail() -> None:
        tried.append(1)
        raise ConnectionResetError("reset")

    with pytest.raises(BadInput, match="x: reset"):
        attempts.persistently(fail, "x")
    assert len(tried) == 7
    tried.clear()
    with pytest.raises(BadInput, match="x: no"):
        attempts.persistently(lambda: tried.append(1) or (_ for _ in ()).throw(PermissionError("no")), "x")
    assert len(tried) == 1


@pytest.mark.parametrize(
    ("uri", "missing", "said"), [("s3://b/x", "s3fs", r"razer\[s3\]"), ("gs://b/x", "gcsfs", "gcsfs")]
)
def test_a_missing_library_is_named(monkeypatch, uri, missing, said):
    from importlib import util

    real = util.find_spec
    for module in ("app.settings.extra_libraries", "app.object_store.place"):
        monkeypatch.setattr(f"{module}.find_spec", lambda name: None if name == missing else real(name))
    with pytest.raises(BadInput, match=said):
        Place.of(uri)
