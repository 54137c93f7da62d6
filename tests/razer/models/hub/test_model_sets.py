"""`razer models pull starter` from a hub on this machine: what is shown, skipped, resumed and refused."""

from __future__ import annotations

import hashlib
import json
from collections import namedtuple
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from huggingface_hub import constants, file_download

from razer.models.hub import download
from razer.models.hub.cache import cached_model
from razer.models.hub.catalogue import catalogue
from razer.models.hub.model_sets import STARTER
from tests.support.cli import razer
from tests.support.hub_server import Hub, serving

Usage = namedtuple("Usage", "total used free")
PERMISSIVE = ("MIT", "Apache-2.0", "BSD-3-Clause")


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Hub]:
    """The repositories of the set, with other content; the catalogue knows the checksums of that."""
    random = np.random.default_rng(0)
    files = {
        each.name: {name: random.bytes(300 if name.endswith(".json") else 20_000) for name in each.files}
        for each in STARTER.entries
    }
    known = dict(catalogue())
    for each in STARTER.entries:
        checked = {name: hashlib.sha256(files[each.name][name]).hexdigest() for name in each.sha256}
        known[each.name] = replace(each, sha256=checked)
    monkeypatch.setattr("razer.models.hub.catalogue.catalogue", lambda: known)
    with serving(Hub({known[name].repo: content for name, content in files.items()})) as hub:
        monkeypatch.setattr(constants, "ENDPOINT", hub.url)
        template = hub.url + "/{repo_id}/resolve/{revision}/{filename}"
        monkeypatch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", template)
        monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
        monkeypatch.setattr(constants, "DOWNLOAD_CHUNK_SIZE", 1000)
        monkeypatch.setattr(file_download.time, "sleep", lambda seconds: None)
        yield hub


def bodies(hub: Hub) -> list[bytes]:
    return [body for files in hub.repos.values() for body in files.values()]


def test_everybody_may_use_the_starter_for_anything() -> None:
    for each in STARTER.entries:
        assert each.licence in PERMISSIVE
        assert not each.accept
        assert any(name in each.sha256 for name in each.files)  # the weights cannot change unnoticed
    assert {each.use for each in STARTER.entries} == {"segmenter rfdetr", "segmenter semantic", "embedder clip"}


def test_licences_sizes_and_checksums_are_shown_before_anything_is_fetched(hub, capsys, monkeypatch) -> None:
    total = sum(map(len, bodies(hub)))
    # Room for each file, but not for all of them.
    monkeypatch.setattr(download.shutil, "disk_usage", lambda path: Usage(0, 0, total - 1))
    code, _, err = razer(capsys, "models", "pull", "starter")
    assert (code, hub.gets()) == (2, [])
    assert "no room for" in err.splitlines()[-1]
    for each in STARTER.entries:
        assert f"{each.name}: licence {each.licence} ({each.page}), {each.megabytes} MB" in err
        for name in each.files:
            body = hub.repos[each.repo][name]
            line = next(line for line in err.splitlines() if line.startswith(f"{each.name}: {name}, "))
            assert f"{len(body) / 1e6:.1f} MB" in line
            assert hashlib.sha256(body).hexdigest() in line or "git id " in line
    assert f"starter: {STARTER.megabytes} MB in all" in err
    assert f"to fetch: {total / 1e6:.1f} MB in {len(bodies(hub))} files" in err


def test_all_members_come_and_a_second_pull_asks_for_nothing(hub, capsys) -> None:
    code, out, err = razer(capsys, "models", "pull", "starter")
    assert code == 0
    assert out.split() == [str(cached_model(each)) for each in STARTER.entries]
    assert "`razer run` uses them" in err
    for each in STARTER.entries:
        snapshot = cached_model(each)
        assert snapshot is not None
        folder = snapshot if snapshot.is_dir() else snapshot.parent
        assert {name: (folder / name).read_bytes() for name in each.files} == hub.repos[each.repo]
    hub.log.clear()
    code, _, err = razer(capsys, "models", "pull", "starter", "--json")
    assert (code, hub.log) == (0, [])
    assert err.count("here already") == len(STARTER.members)


def test_a_pull_that_broke_off_goes_on_where_it_stopped(hub, capsys) -> None:
    assert razer(capsys, "models", "pull", STARTER.members[0])[0] == 0
    hub.log.clear()
    hub.cut_at, hub.goes_down = 7_000, True
    code, _, err = razer(capsys, "models", "pull", "starter")
    assert code == 2
    assert "run the command again to go on" in err.splitlines()[-1]
    assert f"{STARTER.members[0]}: here already" in err
    hub.down = False
    hub.log.clear()
    code, out, _ = razer(capsys, "models", "pull", "starter", "--json")
    assert code == 0
    assert next(part for _, part in hub.gets()) == "bytes=7000-"
    answer = json.loads(out.splitlines()[-1])
    assert (answer["name"], answer["megabytes"]) == ("starter", STARTER.megabytes)
    assert [each["name"] for each in answer["models"]] == list(STARTER.members)
    assert all(Path(each["path"]).exists() and each["sets"] == ["starter"] for each in answer["models"])


def test_list_and_info_say_what_the_set_is_and_what_was_not_tried(capsys) -> None:
    listed = razer(capsys, "models", "list")[1]
    assert f"starter: {' + '.join(STARTER.members)}, {STARTER.megabytes} MB" in listed
    assert "rf-detr-seg-small: segmenter rfdetr, 131 MB, Apache-2.0 **" in listed
    assert "** read by what its page says" in listed
    text = razer(capsys, "models", "info", "starter")[1]
    for each in STARTER.entries:
        assert f"page: {each.page}" in text
        assert all(known in text for known in each.sha256.values())
    assert text.count("tried: not with its real weights") == len(STARTER.members)
    described = json.loads(razer(capsys, "models", "info", "starter", "--json")[1])
    assert [each["licence"] for each in described["models"]] == [each.licence for each in STARTER.entries]
    code, _, err = razer(capsys, "models", "pull", "startr")
    assert (code, "did you mean starter" in err) == (2, True)
