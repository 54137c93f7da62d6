"""Models fetched from a hub on this machine: what lands in the cache, what is resumed, what is refused."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import subprocess
import sys
from collections import namedtuple
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest
from huggingface_hub import constants, file_download

from app.commands.prepare.models import pull
from razer.errors import BadInput
from razer.models import EMBEDDERS, SEGMENTERS, make_segmenter
from razer.models.hub import download
from razer.models.hub.cache import cached_model
from razer.models.hub.catalogue import CatalogueEntry, catalogue, entry
from razer.models.hub.model_file import model_file
from tests.support.hub_server import COMMIT, Hub, serving
from tests.support.sam_exports import EXPORTS

REPO = "someone/some-model"
WEIGHTS = np.random.default_rng(0).bytes(50_000)
FILES = {"weights.onnx": WEIGHTS, "config.json": b'{"a": 1}', "extra.json": b"{}", "notes.md": b"not wanted"}
PAIR = CatalogueEntry("pair", "segmenter sam", "", REPO, "main", ("config.json", "weights.onnx"), "MIT", 1)
ONE = CatalogueEntry("one", "segmenter yolo", "", REPO, COMMIT, ("weights.onnx",), "MIT", 1)
PATTERN = CatalogueEntry("many", "embedder clip", "", REPO, "main", ("*.json", "weights.onnx"), "MIT", 1)
Usage = namedtuple("Usage", "total used free")


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Hub]:
    with serving(Hub({REPO: dict(FILES)})) as hub:
        monkeypatch.setattr(constants, "ENDPOINT", hub.url)
        monkeypatch.setattr(
            constants, "HUGGINGFACE_CO_URL_TEMPLATE", hub.url + "/{repo_id}/resolve/{revision}/{filename}"
        )
        monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
        monkeypatch.setattr(constants, "DOWNLOAD_CHUNK_SIZE", 1000)
        monkeypatch.setattr(file_download.time, "sleep", lambda seconds: None)
        yield hub


def fetch(wanted: CatalogueEntry) -> tuple[Path, list[str]]:
    reported: list[str] = []
    return download.fetch(wanted, reported.append), reported


def partials(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*.incomplete") if path.is_file()]


def test_several_files_give_their_folder_and_nothing_else(hub: Hub) -> None:
    folder, reported = fetch(PAIR)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {n: FILES[n] for n in PAIR.files}
    assert [line.split(":")[0] for line in reported] == ["config.json", "weights.onnx"]
    assert folder.name == COMMIT


def test_one_file_gives_the_file(hub: Hub) -> None:
    path, _ = fetch(ONE)
    assert path.name == "weights.onnx"
    assert path.read_bytes() == WEIGHTS


def test_patterns_are_filled_in_from_the_listing_and_the_largest_comes_last(hub: Hub) -> None:
    folder, reported = fetch(PATTERN)
    assert {path.name for path in folder.iterdir()} == {"weights.onnx", "config.json", "extra.json"}
    assert reported[-1].startswith("weights.onnx")


def test_what_is_there_is_not_asked_for_again(hub: Hub) -> None:
    first, _ = fetch(PAIR)
    hub.log.clear()
    assert fetch(PAIR) == (first, [])
    assert hub.log == []


def test_a_connection_that_breaks_is_taken_up_where_it_broke(hub: Hub) -> None:
    hub.cut_at = 20_000
    path, _ = fetch(ONE)
    assert path.read_bytes() == WEIGHTS
    assert [part for _, part in hub.gets()] == [None, "bytes=20000-"]


def test_a_download_that_ended_is_resumed_by_the_next_one(hub: Hub) -> None:
    hub.cut_at, hub.goes_down = 30_000, True
    with pytest.raises(BadInput, match="run the command again to go on"):
        fetch(ONE)
    assert cached_model(ONE) is None
    assert [path.stat().st_size for path in partials(Path(constants.HF_HUB_CACHE))] == [30_000]
    hub.down = False
    hub.log.clear()
    path, reported = fetch(ONE)
    assert path.read_bytes() == WEIGHTS
    assert [part for _, part in hub.gets()] == ["bytes=30000-"]
    assert "of them here already" in reported[0]
    assert partials(Path(constants.HF_HUB_CACHE)) == []


def test_damaged_content_is_refused_and_leaves_nothing(hub: Hub) -> None:
    hub.damaged = True
    with pytest.raises(BadInput, match="came damaged: sha256"):
        fetch(ONE)
    assert cached_model(ONE) is None
    assert partials(Path(constants.HF_HUB_CACHE)) == []
    hub.damaged = False
    assert fetch(ONE)[0].read_bytes() == WEIGHTS


def test_a_small_file_is_checked_by_its_git_id(hub: Hub) -> None:
    hub.damaged = True
    with pytest.raises(BadInput, match=r"config\.json came damaged: git id"):
        fetch(PAIR)


def test_another_file_than_the_catalogue_knows_is_not_even_fetched(hub: Hub) -> None:
    known = replace(ONE, sha256={"weights.onnx": hashlib.sha256(b"other").hexdigest()})
    with pytest.raises(BadInput, match="is not what it was"):
        fetch(known)
    assert hub.gets() == []


def test_a_leftover_longer_than_the_file_is_thrown_away(hub: Hub) -> None:
    name = f"models--{REPO.replace('/', '--')}"
    blobs = Path(constants.HF_HUB_CACHE) / name / "blobs"
    blobs.mkdir(parents=True)
    (blobs / f"{hashlib.sha256(WEIGHTS).hexdigest()}.incomplete").write_bytes(b"x" * 60_000)
    assert fetch(ONE)[0].read_bytes() == WEIGHTS


def test_no_room_is_reported_before_the_download(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(download.shutil, "disk_usage", lambda path: Usage(0, 0, 1000))
    with pytest.raises(BadInput, match=r"no room for weights\.onnx.*HF_HOME"):
        fetch(ONE)
    assert hub.gets() == []


class FullDisk:
    """A file on a disk that takes 5,000 bytes."""

    def __init__(self, file: object) -> None:
        self._file, self._room = file, 5_000

    def __getattr__(self, name: str) -> object:
        return getattr(self._file, name)

    def __enter__(self) -> FullDisk:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def write(self, data: bytes) -> int:
        if len(data) > self._room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._room -= len(data)
        return self._file.write(data)


def test_a_disk_that_fills_up_is_reported_and_resumed_later(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = Path.open

    def on_full_disk(path: Path, mode: str = "r", **rest: object) -> object:
        file = opened(path, mode, **rest)
        return FullDisk(file) if mode == "ab" else file

    with monkeypatch.context() as full:
        full.setattr(Path, "open", on_full_disk)
        with pytest.raises(BadInput, match="no room left"):
            fetch(ONE)
    assert cached_model(ONE) is None
    hub.log.clear()
    assert fetch(ONE)[0].read_bytes() == WEIGHTS
    assert hub.gets()[0][1] == "bytes=5000-"


def test_ctrl_c_keeps_what_came(hub: Hub, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def stopped(url: str, target: BinaryIO, **options: object) -> None:
        target.write(WEIGHTS[:10_000])
        raise KeyboardInterrupt

    monkeypatch.setattr("app.commands.prepare.models.entries_of", lambda name: (ONE,))
    with monkeypatch.context() as during:
        during.setattr(download, "http_get", stopped)
        assert pull("one") == 130
    assert "to go on" in capsys.readouterr().err
    assert pull("one") == 0
    assert [part for _, part in hub.gets()] == ["bytes=10000-"]
    assert capsys.readouterr().out.strip() == str(cached_model(ONE))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"files": ("gone.onnx",)}, "no such file"),
        ({"repo": "someone/gone"}, "no such file"),
        ({"files": ("*.safetensors",)}, r"holds no \*\.safetensors"),
    ],
)
def test_what_the_hub_does_not_have_is_one_line(hub: Hub, change: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message) as caught:
        fetch(replace(ONE, revision="main", **change))
    assert "\n" not in str(caught.value)


def test_a_gated_model_says_how_to_log_in(hub: Hub) -> None:
    hub.gated = {REPO}
    with pytest.raises(BadInput, match="hf auth login"):
        fetch(ONE)


def test_without_a_network_there_is_one_line_and_what_is_cached_stays(
    hub: Hub, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = fetch(ONE)
    monkeypatch.setattr(
        constants, "HUGGINGFACE_CO_URL_TEMPLATE", "http://127.0.0.1:9/{repo_id}/resolve/{revision}/{filename}"
    )
    assert fetch(ONE)[0] == path
    with pytest.raises(BadInput, match="cannot be reached"):
        fetch(PAIR)


def test_offline_by_choice(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    with pytest.raises(BadInput, match="HF_HUB_OFFLINE"):
        fetch(ONE)


def test_a_name_resolves_to_what_was_fetched(hub: Hub, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("razer.models.hub.model_file.catalogue", lambda: {"one": ONE, "pair": PAIR})
    with pytest.raises(BadInput, match=r"'one' is not downloaded: run 'razer models pull one'; without it"):
        model_file("one")
    path, _ = fetch(ONE)
    assert model_file("one") == path
    assert model_file(path) == path
    assert model_file(tmp_path) == tmp_path
    with pytest.raises(BadInput, match="no such name in the catalogue"):
        model_file(tmp_path / "none.onnx")
    with pytest.raises(BadInput, match="hf download some/thing"):
        model_file("some/thing")


def test_a_hub_id_resolves_to_its_folder(hub: Hub) -> None:
    folder, _ = fetch(PAIR)
    assert model_file(REPO) == folder


def test_a_segmenter_takes_a_pulled_pair_by_its_name(hub: Hub, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    export = EXPORTS["sam2.1"]
    export.write(tmp_path)
    names = (export.encoder, export.decoder)
    hub.repos[REPO] = {name: (tmp_path / name).read_bytes() for name in names}
    monkeypatch.setattr(
        "razer.models.hub.model_file.catalogue", lambda: {"tiny": replace(PAIR, name="tiny", files=names)}
    )
    with pytest.raises(BadInput, match="razer models pull tiny"):
        make_segmenter("sam", {"weights": "tiny"})
    fetch(replace(PAIR, files=names))
    assert make_segmenter("sam", {"weights": "tiny"}).limits.points == 16


def test_every_entry_is_complete() -> None:
    for each in catalogue().values():
        assert each.task in ("segmenter", "embedder")
        assert set(each.sha256) <= set(each.files)
        assert all(len(value) == 64 for value in each.sha256.values())
        assert each.megabytes > 0
        assert each.about
        assert "AGPL" not in each.licence or each.accept
        assert each.page == f"https://huggingface.co/{each.repo}"
        assert each.part in (SEGMENTERS if each.task == "segmenter" else EMBEDDERS)
        assert each.needs in ("", "transformers", "tokenizers")


def test_a_misspelt_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(BadInput, match="mobile-sam"):
        entry("mobilesam")


def run(hub: Hub, home: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "HF_ENDPOINT": hub.url, "HF_HOME": str(home), "HF_HUB_OFFLINE": "0"}
    command = [sys.executable, "-m", "app", "models", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=100, check=False)


def test_the_verb_from_the_outside(tmp_path: Path) -> None:
    wanted = entry("mask2former-coco")
    files = {name: name.encode() * 400 for name in wanted.files}
    agpl = entry("yolo11n-seg")
    with serving(Hub({wanted.repo: files, agpl.repo: {agpl.files[0]: b"x" * 2000}})) as hub:
        done = run(hub, tmp_path, "pull", wanted.name, "--json")
        assert done.returncode == 0, done.stderr
        assert f"licence {wanted.licence}" in done.stderr
        path = Path(json.loads(done.stdout.splitlines()[-1])["path"])
        assert {name: (path / name).read_bytes() for name in wanted.files} == files
        asked = len(hub.log)
        refused = run(hub, tmp_path, "pull", agpl.name)
        assert (refused.returncode, len(hub.log)) == (2, asked)
        assert "--accept-license" in refused.stderr.splitlines()[-1]
        other = run(hub, tmp_path, "pull", agpl.name, "--accept-license")
        assert other.returncode == 2
        assert "is not what it was" in other.stderr.splitlines()[-1]
        listed = json.loads(run(hub, tmp_path, "list", "--json").stdout)
        assert [row["name"] for row in listed if row["path"]] == [wanted.name]
        assert str(path) in run(hub, tmp_path, "info", wanted.name).stdout
