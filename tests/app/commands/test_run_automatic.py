"""`razer run` without naming models: what a stranger reads, what the run folder keeps, how it is repeated."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from huggingface_hub import constants

from razer.models.hub.model_sets import STARTER
from razer.saved_map import load_map
from tests.support.cli import QUICK, razer, write_small_room
from tests.support.hub_cache import put_into_cache, put_starter, without_checksums
from tests.support.rfdetr_exports import CHAIR, logits, write_rfdetr


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_room(tmp_path_factory.mktemp("room") / "recording", n_frames=3)


@pytest.fixture
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
    without_checksums(monkeypatch)
    return tmp_path / "cache"


def settings(run: Path) -> dict:
    return tomllib.loads((run / "config.toml").read_text())


def test_without_weights_one_line_says_what_is_used_and_the_folder_repeats_it(capsys, cache, tmp_path, room) -> None:
    common, first = ("run", room, *QUICK, "--no-timeline"), tmp_path / "first"
    code, out, err = razer(capsys, *common, "-o", first, "--json")
    assert code == 0
    lines = [line for line in err.splitlines() if line.startswith("auto: ")]
    assert len(lines) == 1
    assert "--segmenter geometric" in lines[0]
    assert "--embedder appearance" in lines[0]
    assert f"better: razer models pull starter ({STARTER.megabytes} MB)" in lines[0]
    kept = settings(first)
    for section, name in (("segmenter", "geometric"), ("embedder", "appearance")):
        assert (kept[section]["name"], kept[section]["asked"]) == (name, "auto")
        assert json.loads(out.splitlines()[-1])[section] == {"name": name, "asked": "auto"}
    code, _, err = razer(capsys, "query", first, "a chair")
    assert (code, "razer models pull starter" in err) == (2, True)

    # What came since changes what is asked anew, and not what is repeated.
    labels = logits([{CHAIR: 0.9}])
    put_into_cache(cache, STARTER.members[0], lambda folder: write_rfdetr(folder / "rfdetr-seg-small.onnx", labels))
    assert 'segmenter.name = "auto"   here: rfdetr+geometric' in razer(capsys, "config")[1]
    code, _, err = razer(capsys, *common, "--config", first / "config.toml", "-o", tmp_path / "again")
    assert code == 0
    assert "auto: " not in err
    assert (first / "mesh.ply").read_bytes() == (tmp_path / "again" / "mesh.ply").read_bytes()
    assert "asked" not in settings(tmp_path / "again")["segmenter"]


@pytest.mark.full
def test_with_the_starter_a_run_has_things_surfaces_and_words(capsys, cache, tmp_path) -> None:
    put_starter(cache)
    # Models without training are unsure of what they see, so that a few frames of it are no evidence.
    room = write_small_room(tmp_path / "recording", n_frames=12)
    code, _, err = razer(capsys, "run", room, "-o", tmp_path / "run", *QUICK, "--no-timeline")
    assert code == 0
    assert next(line for line in err.splitlines() if line.startswith("auto: ")) == (
        f"auto: --segmenter rfdetr+semantic ({STARTER.members[0]}, {STARTER.members[1]}) "
        f"--embedder clip ({STARTER.members[2]})"
    )
    assert settings(tmp_path / "run")["embedder"]["options"] == {"weights": STARTER.members[2]}
    named = {item.class_name for item in load_map(tmp_path / "run").objects}
    assert named
    assert named <= {"chair", "cup", "wall"}  # the names of both
    assert razer(capsys, "query", tmp_path / "run", "a chair")[0] == 0


def test_options_need_the_name_of_what_they_are_for(capsys, cache, tmp_path, room) -> None:
    options = ("--set", "segmenter.options.weights=a.onnx")
    code, _, err = razer(capsys, "run", room, "-o", tmp_path / "run", *options)
    assert (code, list(tmp_path.glob("*run*"))) == (2, [])
    assert err.splitlines()[-1].startswith("razer: segmenter.options.weights is an option of one segmenter: name it")


def test_what_auto_stands_for_is_among_the_settings(capsys, cache) -> None:
    _, text, _ = razer(capsys, "config")
    assert 'segmenter.name = "auto"   here: geometric' in text
    rows = {row["name"]: row for row in json.loads(razer(capsys, "config", "--json")[1])}
    assert (rows["embedder.name"]["value"], rows["embedder.name"]["here"]) == ("auto", "appearance")
    assert rows["voxels.voxel_size_m"]["here"] is None
    named = json.loads(razer(capsys, "config", "--set", "segmenter.name=sam", "--json")[1])
    assert {row["name"]: row["here"] for row in named}["segmenter.name"] is None


@pytest.mark.full
def test_a_real_recording_is_mapped_without_weights_and_without_a_word_from_the_user(
    capsys, cache, tmp_path, real_data
) -> None:
    code, out, err = razer(
        capsys, "run", real_data / "redkitchen", "-o", tmp_path / "run", "--stride", 40, "--frames", 8, *QUICK,
        "--no-timeline",
    )  # fmt: skip
    assert code == 0
    assert err.count("better: razer models pull starter") == 1
    assert "8 of 8 frames used" in out
    assert len(load_map(tmp_path / "run").objects) >= 5
