"""A library of one map answers as `PanopticMap.query` does; of many, each hit has the score that its own map gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.library.known_texts import KnownTexts
from app.library.map_search import MapSearch, Wanted
from app.library.tables.instance_library import InstanceLibrary
from app.library.tables.instance_rows import Entry, rows_of
from app.library.tables.model_identity import ModelIdentity
from razer.plugins import EmbedderSettings
from tests.support.libraries import WIDTH, WORDS, AnyText, made_map, picture_vector

ENCODER = KnownTexts(AnyText())
TEXTS = (*WORDS, "a red chair", "cushion", "aeroplane")
MODEL = ModelIdentity.of(EmbedderSettings(name="any"), WIDTH)
SCORE_ERROR = 0.02  # a logistic of 150 times a cosine, which is rounded to 16 bits


def library_of(folder, maps):
    for number, (run, panoptic) in enumerate(maps.items()):
        table = InstanceLibrary.made(str(folder), MODEL)
        table.add(rows_of(panoptic, Entry(run, "here", number + 1, "{}"), MODEL), number + 1)
    return MapSearch(InstanceLibrary(str(folder)).table(None), ENCODER)


def scores_of(answer):
    return {hit.object.id: hit.score for hit in answer.hits}


def assert_same(found, expected, threshold):
    """The same ids and scores, but for those that are as near to the threshold as scores are exact."""
    for i in found.keys() | expected.keys():
        assert abs(found.get(i, threshold) - expected.get(i, threshold)) < SCORE_ERROR, i


@pytest.mark.parametrize("votes", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_library_of_one_map_answers_as_the_map_does(tmp_path, seed, votes):
    panoptic = replace(made_map(seed, votes=votes), text_queries=ENCODER)
    search = library_of(tmp_path, {"run": panoptic})
    n_hits = 0
    for text in TEXTS:
        for threshold in (None, 0.2):
            expected = panoptic.query(text) if threshold is None else panoptic.query(text, threshold)
            answer = search.by_text(text, Wanted(100, min_score=threshold))
            assert answer.threshold == expected.threshold
            assert_same({h.hit.object.id: h.hit.score for h in answer.hits}, scores_of(expected), expected.threshold)
            guesses = {hit.object.id: hit.class_guess for hit in expected.hits}
            assert all(guesses.get(h.hit.object.id, h.hit.class_guess) == h.hit.class_guess for h in answer.hits)
            n_hits += len(expected.hits)
    assert n_hits > 10


@pytest.mark.parametrize("seed", [0, 1])
def test_a_library_of_one_map_answers_a_vector_as_the_map_does(tmp_path, seed):
    panoptic = made_map(seed)
    search = library_of(tmp_path, {"run": panoptic})
    for word in WORDS:
        vector = picture_vector(word, np.random.default_rng(seed))
        answer = search.by_vector(vector, Wanted(100))
        found = {h.hit.object.id: h.hit.score for h in answer.hits}
        assert_same(found, scores_of(panoptic.query_image(vector)), answer.threshold)


def test_each_hit_of_many_maps_has_the_score_of_its_own_map(tmp_path):
    maps = {f"run {i}": replace(made_map(i, votes=i % 2 == 0), text_queries=ENCODER) for i in range(12)}
    search = library_of(tmp_path, maps)
    for text in TEXTS:
        answer = search.by_text(text, Wanted(1000, min_score=0.3))
        for run, panoptic in maps.items():
            own = {h.hit.object.id: h.hit.score for h in answer.hits if h.run == run}
            assert_same(own, scores_of(panoptic.query(text, 0.3)), 0.3)
        scores = [h.hit.score for h in answer.hits]
        assert scores == sorted(scores, reverse=True)


def test_what_is_stored_of_an_instance_comes_back(tmp_path):
    panoptic = made_map(5, votes=True)
    search = library_of(tmp_path, {"run": panoptic})
    (stored,) = search.opened(["run"])
    for one, other in zip(
        (*panoptic.objects, *panoptic.parts), (*stored.queries.objects, *stored.queries.parts), strict=True
    ):
        assert (one.id, one.class_name, one.part_of, one.is_stuff) == (
            other.id, other.class_name, other.part_of, other.is_stuff,
        )  # fmt: skip
        np.testing.assert_allclose(one.embeddings, other.embeddings, atol=1e-3)
        np.testing.assert_allclose(one.weights, other.weights, atol=1e-6)
        for part in ("center", "rotation", "extent"):
            np.testing.assert_allclose(getattr(one.box, part), getattr(other.box, part), atol=1e-5)
        assert [(v.name, v.sector, v.frames) for v in one.class_votes] == [
            (v.name, v.sector, v.frames) for v in other.class_votes
        ]


def test_a_map_that_was_added_again_is_not_asked_as_it_was(tmp_path):
    search = library_of(tmp_path, {"run": made_map(0)})
    before = search.by_text("chair", Wanted(100, min_score=0.0))
    changed = made_map(0)
    changed = replace(changed, objects=changed.objects[1:], parts=())
    table = InstanceLibrary(str(tmp_path)).table(None)
    table.add(rows_of(changed, Entry("run", "here", 99, "{}"), MODEL), 99)
    after = search.by_text("chair", Wanted(100, min_score=0.0))
    assert {h.hit.object.id for h in before.hits} - {h.hit.object.id for h in after.hits} >= {1}


def test_size_and_place_are_told_in_the_room_s_own_frame(tmp_path):
    panoptic = made_map(4)
    rows = rows_of(panoptic, Entry("run", "here", 1, "{}"), MODEL).to_pylist()
    low = np.quantile(panoptic.mesh.vertices[:, 2], 0.01)
    for item in panoptic.objects:
        row = next(row for row in rows if row["id"] == item.id)
        x, y, z = item.box.extent.tolist()
        assert row["height_m"] == pytest.approx(z, abs=1e-5)
        assert (row["width_m"], row["depth_m"]) == pytest.approx((max(x, y), min(x, y)), abs=1e-5)
        assert row["above_floor_m"] == pytest.approx(item.box.center[2] - z / 2 - low, abs=1e-4)
        assert 0 <= row["room_x"] <= 1


def test_an_instance_that_people_named_is_found_without_a_vector(tmp_path):
    panoptic = made_map(6)
    named = replace(
        panoptic.objects[0], class_name="espresso machine", is_named_by_hand=True,
        embeddings=np.zeros((0, 0), np.float32), weights=np.zeros(0),
    )  # fmt: skip
    panoptic = replace(panoptic, objects=(named, *panoptic.objects[1:]), text_queries=ENCODER)
    search = library_of(tmp_path, {"run": panoptic, "other": made_map(7)})
    hits = search.by_text("the espresso machine", Wanted(1)).hits
    assert [(h.run, h.hit.object.id, h.hit.score) for h in hits] == [("run", named.id, 1.0)]
    assert [hit.object.id for hit in panoptic.query("the espresso machine").hits] == [named.id]
