"""Cached models held against their published checksums: what was changed after the download is not opened."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from huggingface_hub import constants, file_download

from razer.errors import BadInput
from razer.models.hub import cached_content
from razer.models.hub.cache import cached_model
from razer.models.hub.catalogue import CatalogueEntry, catalogue
from razer.models.hub.model_file import model_file
from tests.support.cli import razer, write_small_room
from tests.support.hub_cache import put_into_cache, without_checksums
from tests.support.hub_server import Hub, serving

NAME = "mask2former-coco"  # several files, no checksum in the catalogue
PINNED = "yolo11n-seg"  # one file with one
WEIGHTS = np.random.default_rng(3).bytes(20_000)


@pytest.fixture(autouse=True)
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """An empty cache, and a catalogue whose first entry is of the newest revision, as the made-up hub has one alone."""
    known = {**catalogue(), NAME: replace(catalogue()[NAME], revision="main")}
    monkeypatch.setattr("razer.models.hub.catalogue.catalogue", lambda: known)
    monkeypatch.setattr("razer.models.hub.model_file.catalogue", lambda: known)
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def write_files(folder: Path) -> None:
    for name in catalogue()[NAME].files:
        content = json.dumps({"name": name}).encode() if name.endswith(".json") else WEIGHTS
        (folder / name).write_bytes(content)


def write_pinned(folder: Path) -> None:
    file = folder / catalogue()[PINNED].files[0]
    file.parent.mkdir(parents=True)
    file.write_bytes(WEIGHTS)


@pytest.fixture
def snapshot(cache: Path) -> Path:
    return put_into_cache(cache, NAME, write_files)


def large(snapshot: Path) -> Path:
    return next(path for path in snapshot.iterdir() if path.stat().st_size == len(WEIGHTS))


def flip_a_bit(file: Path) -> None:
    """One bit of a blob, with its time and size as they were: what a failing disk does."""
    blob, times = file.resolve(), (file.stat().st_atime_ns, file.stat().st_mtime_ns)
    content = bytearray(blob.read_bytes())
    content[len(content) // 2] ^= 1
    blob.write_bytes(content)
    os.utime(blob, ns=times)
    cached_content._checksum.cache_clear()  # as in a program started after that


def test_what_is_whole_is_opened(snapshot: Path) -> None:
    assert model_file(NAME) == snapshot
    assert model_file(snapshot) == snapshot
    assert model_file(catalogue()[NAME].repo) == snapshot


@pytest.mark.parametrize("which", ["weights", "config.json"])
@pytest.mark.parametrize("given", ["name", "hub id", "path"])
def test_one_changed_bit_is_one_line_with_the_way_out(snapshot: Path, which: str, given: str) -> None:
    file = large(snapshot) if which == "weights" else snapshot / which
    published = file.resolve().name
    flip_a_bit(file)
    repo = catalogue()[NAME].repo
    command = f"razer models pull {NAME}" if given == "name" else f"hf download {repo} --force-download"
    with pytest.raises(BadInput) as caught:
        model_file({"name": NAME, "hub id": repo, "path": snapshot}[given])
    said = str(caught.value)
    assert "\n" not in said
    assert str(file) in said
    assert f"{'sha256' if which == 'weights' else 'git id'} " in said
    assert f"expected {published}; run '{command}'" in said


def test_a_file_put_in_place_of_a_link_is_held_against_the_catalogue(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    weights = catalogue()[PINNED].files[0]
    pinned = replace(catalogue()[PINNED], sha256={weights: hashlib.sha256(WEIGHTS).hexdigest()})
    monkeypatch.setattr("razer.models.hub.model_file.catalogue", lambda: {PINNED: pinned})
    snapshot = put_into_cache(cache, PINNED, write_pinned)
    assert model_file(PINNED) == snapshot / weights
    (snapshot / weights).unlink()
    (snapshot / weights).write_bytes(WEIGHTS[:-1] + b"!")
    with pytest.raises(BadInput, match=r"models pull yolo11n-seg --accept-license'"):
        model_file(PINNED)


def test_a_file_changed_while_a_program_runs_is_told(snapshot: Path) -> None:
    model_file(NAME)
    large(snapshot).resolve().write_bytes(WEIGHTS[:-1] + b"!")
    with pytest.raises(BadInput, match="is damaged or was replaced"):
        model_file(NAME)


def test_one_reading_is_enough_for_one_program(snapshot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model_file(NAME)
    monkeypatch.setattr(cached_content, "checksum", lambda path, kind: pytest.fail(f"{path} read twice"))
    model_file(NAME)
    model_file(snapshot)


def test_files_that_the_catalogue_does_not_name_and_those_outside_the_cache_are_not_looked_at(
    snapshot: Path, tmp_path: Path
) -> None:
    (snapshot / "notes.txt").symlink_to(Path("..", "..", "blobs", "0" * 64))
    (snapshot.parents[1] / "blobs" / ("0" * 64)).write_text("other")
    assert model_file(NAME) == snapshot
    with pytest.raises(BadInput, match=r"notes\.txt is damaged"):
        model_file(catalogue()[NAME].repo)
    own = tmp_path / "own" / ("0" * 64)
    own.parent.mkdir()
    own.write_text("the user's, whatever its name")
    assert model_file(own.parent) == own.parent


def test_a_damaged_model_ends_a_verb_with_exit_code_2(snapshot: Path, capsys, tmp_path: Path) -> None:
    flip_a_bit(large(snapshot))
    settings = ("--segmenter", "panoptic", "--set", f"segmenter.options.weights={NAME}")
    room = write_small_room(tmp_path / "recording", n_frames=3)
    code, _, err = razer(capsys, "run", room, "-o", tmp_path / "out", *settings)
    assert code == 2
    assert "is damaged or was replaced: sha256" in err.splitlines()[-1]
    assert not (tmp_path / "out").exists()


@pytest.fixture
def hub(snapshot: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hub]:
    wanted = catalogue()[NAME]
    with serving(Hub({wanted.repo: {name: (snapshot / name).read_bytes() for name in wanted.files}})) as hub:
        monkeypatch.setattr(constants, "ENDPOINT", hub.url)
        template = hub.url + "/{repo_id}/resolve/{revision}/{filename}"
        monkeypatch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", template)
        monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
        monkeypatch.setattr(file_download.time, "sleep", lambda seconds: None)
        yield hub


def test_a_pull_fetches_what_is_damaged_and_that_alone(hub: Hub, snapshot: Path, capsys) -> None:
    code, _, err = razer(capsys, "models", "pull", NAME)
    assert (code, "here already" in err, hub.log) == (0, True, [])
    flip_a_bit(large(snapshot))
    code, _, err = razer(capsys, "models", "pull", NAME)
    assert code == 0, err
    assert f"{large(snapshot).name}: damaged in the cache, fetched anew" in err
    assert "here already" not in err
    assert len(hub.gets()) == 1
    assert large(snapshot).read_bytes() == WEIGHTS
    assert model_file(NAME) == snapshot


def test_whole_content_of_another_version_is_left_to_other_programs(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from razer.models.hub.download import whole_model

    pinned: CatalogueEntry = catalogue()[PINNED]
    snapshot = put_into_cache(cache, PINNED, write_pinned)
    blob = (snapshot / pinned.files[0]).resolve()
    said: list[str] = []
    assert whole_model(pinned, said.append) is None
    assert len(said) == 1
    assert blob.read_bytes() == WEIGHTS
    assert cached_model(pinned) is None


def test_checksums_of_the_catalogue_are_those_of_its_files(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    """Guards the helper: with the catalogue's own checksums a made-up file is refused, without them it is not."""
    put_into_cache(cache, PINNED, write_pinned)
    with pytest.raises(BadInput, match=r"is damaged or was replaced"):
        model_file(PINNED)
    without_checksums(monkeypatch)
    model_file(PINNED)
