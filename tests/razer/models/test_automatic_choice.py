"""What "auto" stands for, by the models in the cache and the packages that are installed."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from huggingface_hub import constants

import razer
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.models import automatic_choice as module
from razer.models.automatic_choice import STUFF, THINGS, WORDS, automatic_choice
from razer.models.hub.catalogue import CatalogueEntry, entry
from razer.models.hub.model_sets import STARTER
from razer.plugins import EmbedderSettings, SegmenterSettings
from tests.support.hub_cache import put_into_cache, put_starter, without_checksums

DETECTOR, SURFACES, TOWERS = STARTER.members
ANY = SegmenterSettings(), EmbedderSettings()


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch):
    """Says which models are in the cache, and which packages are not installed."""

    def say(models: tuple[str, ...], without: tuple[str, ...] = ()) -> None:
        def cached(each: CatalogueEntry) -> Path | None:
            return Path(each.name) if each.name in models else None

        monkeypatch.setattr("razer.models.hub.cache.cached_model", cached)
        monkeypatch.setattr(module, "find_spec", lambda name: None if name in without else object())

    return say


W = "weights"
CHOICES = [
    ((), "geometric", {}, "appearance", {}),
    (STARTER.members, "rfdetr+semantic", {"rfdetr": {W: DETECTOR}, "semantic": {W: SURFACES}}, "clip", {W: TOWERS}),
    ((DETECTOR,), "rfdetr+geometric", {"rfdetr": {W: DETECTOR}}, "appearance", {}),
    ((SURFACES,), "geometric+semantic", {"semantic": {W: SURFACES}}, "appearance", {}),
    ((TOWERS,), "geometric", {}, "clip", {W: TOWERS}),
    (("yolov8n-seg", "yolo11m-seg"), "yolo+geometric", {"yolo": {W: "yolo11m-seg"}}, "appearance", {}),
    (("mask2former-coco",), "panoptic", {W: "mask2former-coco"}, "appearance", {}),
    (
        ("yolo11n-seg", "oneformer-coco"),
        "yolo+panoptic",
        {"yolo": {W: "yolo11n-seg"}, "panoptic": {W: "oneformer-coco"}},
        "appearance",
        {},
    ),
    (("siglip2-base",), "geometric", {}, "clip", {W: "siglip2-base"}),
    (("siglip2-base", TOWERS), "geometric", {}, "clip", {W: TOWERS}),
    (("mobile-sam", "sam3"), "geometric", {}, "appearance", {}),
]


@pytest.mark.parametrize(("models", "segmenter", "its_options", "embedder", "options"), CHOICES)
def test_what_is_here_is_combined(here, models, segmenter, its_options, embedder, options) -> None:
    here(models)
    choice = automatic_choice(*ANY)
    assert (choice.segmenter.name, choice.segmenter.options) == (segmenter, its_options)
    assert (choice.embedder.name, choice.embedder.options) == (embedder, options)
    assert (choice.segmenter.asked, choice.embedder.asked) == ("auto", "auto")
    assert choice.note.startswith(f"auto: --segmenter {segmenter}")
    assert "\n" not in choice.note
    complete = bool(set(THINGS) & set(models) and set(STUFF) & set(models) and set(WORDS) & set(models))
    assert ("better: razer models pull starter" in choice.note) == (not complete)
    again = automatic_choice(choice.segmenter, choice.embedder)
    assert (again.segmenter, again.embedder, again.note) == (choice.segmenter, choice.embedder, "")


def test_the_note_says_what_is_lacking_how_large_it_is_and_how_to_get_it(here) -> None:
    here((SURFACES,))
    size = entry(DETECTOR).megabytes + entry(TOWERS).megabytes
    assert automatic_choice(*ANY).note == (
        f"auto: --segmenter geometric+semantic ({SURFACES}) --embedder appearance (looks, no words); it lacks names of "
        f"things, words to ask by; better: razer models pull starter ({size} MB)"
    )
    here(STARTER.members)
    assert automatic_choice(*ANY).note == (
        f"auto: --segmenter rfdetr+semantic ({DETECTOR}, {SURFACES}) --embedder clip ({TOWERS})"
    )


def test_a_model_whose_package_is_missing_is_left_out_and_said(here) -> None:
    here(STARTER.members, without=("transformers",))
    choice = automatic_choice(*ANY)
    assert (choice.segmenter.name, choice.embedder.name) == ("rfdetr+geometric", "clip")
    assert choice.note.endswith("it lacks a class for every pixel; better: pip install 'razer[transformers]'")
    here((), without=("transformers", "tokenizers"))
    better = automatic_choice(*ANY).note.partition("better: ")[2]
    assert better == f"pip install 'razer[transformers]' and razer models pull starter ({STARTER.megabytes} MB)"


def test_what_is_named_stays_and_is_not_spoken_of(here) -> None:
    here(STARTER.members)
    oracle, names = SegmenterSettings(name="oracle", options={"noise": "full"}), EmbedderSettings(name="names")
    assert automatic_choice(oracle, names).note == ""
    assert (automatic_choice(oracle, names).segmenter, automatic_choice(oracle, names).embedder) == (oracle, names)
    partly = automatic_choice(oracle, EmbedderSettings())
    assert (partly.segmenter, partly.embedder.name) == (oracle, "clip")
    assert partly.note == f"auto: --embedder clip ({TOWERS})"


def test_options_without_a_name_are_refused(here) -> None:
    here(())
    with pytest.raises(BadInput, match=r"segmenter\.options\.weights is an option of one segmenter: name it"):
        automatic_choice(SegmenterSettings(options={"weights": "a.onnx"}), EmbedderSettings())
    with pytest.raises(BadInput, match=r"embedder\.options\.table .* as in --embedder appearance"):
        automatic_choice(SegmenterSettings(), EmbedderSettings(options={"table": "a.npz"}))


def test_a_cache_that_cannot_be_read_holds_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
    snapshot = put_into_cache(tmp_path / "cache", DETECTOR, lambda folder: (folder / "a.onnx").touch())
    (snapshot.parents[1] / "refs" / "main").write_bytes(b"\xff\xfe")
    assert automatic_choice(*ANY).segmenter.name == "geometric"

    def forbidden(model: CatalogueEntry) -> Path:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("razer.models.hub.cache.cached_model", forbidden)
    assert automatic_choice(*ANY).segmenter.name == "geometric"


def test_candidates_do_what_they_are_listed_for() -> None:
    assert {entry(name).part for name in THINGS} == {"rfdetr", "yolo"}
    assert {entry(name).part for name in STUFF} == {"semantic", "panoptic"}
    assert {entry(name).part for name in WORDS} == {"clip"}
    assert STARTER.members == (THINGS[0], STUFF[0], WORDS[0])
    assert not any(each.accept for each in STARTER.entries)


def test_a_mapper_made_without_names_uses_what_is_here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "cache"))
    assert razer.Mapper().config.segmenter.name == "geometric"
    put_starter(tmp_path / "cache")
    without_checksums(monkeypatch)
    mapper = razer.Mapper()
    assert (mapper.config.segmenter.name, mapper.config.embedder.name) == ("rfdetr+semantic", "clip")
    rgb = np.full((96, 128, 3), 120, np.uint8)
    rgb[20:60, 10:70] = (220, 40, 60)  # the made-up detector's chair
    frame = Frame(0, 0.0, rgb, np.ones((96, 128), np.float32), Intrinsics(128, 96, 90, 90, 64, 48))
    perception = pickle.loads(pickle.dumps(mapper.perception))
    masks = perception.segmenter.segment(frame)
    assert masks.class_names[0] == "chair"
    assert masks.masks[0][40, 40]
    assert masks.masks.any(axis=0).mean() > 0.9  # the rest has a class of the other model
    vectors = perception.embedder.embed(frame, masks)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-5)
    assert perception.embedder.embed_texts(["a chair"]).shape == (1, vectors.shape[1])
