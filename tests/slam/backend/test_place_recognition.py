"""Keyframes by appearance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from slam.backend.inverted_index import InvertedIndex
from slam.backend.place_recognition import PlaceRecognition
from slam.frontend.features import Features
from slam.frontend.wide_features import WideFeatures, packed


@dataclass
class Place:
    """A view of which nothing is known but the descriptors."""

    descriptors: np.ndarray
    wide: WideFeatures = field(init=False)

    def __post_init__(self):
        n = len(self.descriptors)
        features = Features(np.zeros((n, 2)), packed(self.descriptors), np.ones(n), np.ones(n))
        self.wide = WideFeatures.known(features)


def gradients(rng, n=200):
    """Descriptors as SIFT's are: few entries are large."""
    return rng.gamma(0.5, 40, (n, 128)).clip(0, 255).astype(np.uint8)


def noisy(rng, descriptors):
    return (descriptors + rng.normal(0, 8, descriptors.shape)).clip(0, 255).astype(np.uint8)


@pytest.fixture
def scenes(rng):
    return [gradients(rng) for _ in range(70)]


def test_a_place_seen_again_is_the_most_alike_and_stands_out(rng, scenes):
    places = PlaceRecognition()
    for scene in scenes:
        places.add(Place(scene))
    revisited = Place(np.concatenate([noisy(rng, scenes[17][:80]), gradients(rng, 120)]))
    assert places.lookalikes(revisited, range(70), 4.0, 3)[0] == 17
    assert 17 not in places.lookalikes(revisited, [n for n in range(70) if n != 17], 0.0, 70)
    assert places.lookalikes(Place(gradients(rng)), range(70), 10.0, 3) == []
    assert places.lookalikes(revisited, [], 0.0, 3) == []


def test_similarity_is_the_share_of_words_by_their_rarity(rng, scenes):
    """Against a slow reference that compares sets of words."""
    index = InvertedIndex()
    for scene in scenes[:9]:
        index.add(np.concatenate([scene, scenes[60]]))
    index.add(scenes[9][:40])
    view = np.concatenate([scenes[3][:50], scenes[60][:20], scenes[50]])
    those = [*(np.concatenate([scene, scenes[60]]) for scene in scenes[:9]), scenes[9][:40]]
    words = [set(index._words(each).tolist()) for each in those]
    asked = [word for word in index._words(view).tolist() if any(word in have for have in words)]
    weights = {word: np.log(11 / sum(word in have for have in words)) ** 2 for word in asked}
    share = [sum(weights[w] for w in asked if w in have) / sum(weights.values()) for have in words]
    usual = np.mean([len(have) for have in words])
    expected = [s * np.sqrt(usual / len(have)) for s, have in zip(share, words, strict=True)]
    np.testing.assert_allclose(index.similarity(view), expected, rtol=1e-5)


def test_a_keyframe_of_many_words_does_not_come_first_for_that(rng, scenes):
    """A view that shows little that is known, beside a keyframe with four times as much in it."""
    n_first = 0
    for scene in scenes[:40]:
        places = PlaceRecognition()
        for each in (np.concatenate(scenes[60:64]), scene, *scenes[40:46]):
            places.add(Place(each))
        seen = Place(np.concatenate([noisy(rng, scene[:32]), gradients(rng, 168)]))
        n_first += places.lookalikes(seen, range(8), 0.0, 1) == [1]
    assert n_first >= 20  # none, where what is shared is not held against the number of words


def test_words_are_of_all_kinds(rng):
    """A word of 16 comparisons that are as often true as not is one of 65,536."""
    words = InvertedIndex()._words(gradients(rng, 4000))
    assert len(words) > 0.95 * 8 * 65536 * (1 - np.exp(-4000 / 65536))


def test_a_saved_index_answers_the_same(rng, scenes):
    index, again = InvertedIndex(), InvertedIndex.__new__(InvertedIndex)
    for scene in [*scenes[:5], np.zeros((0, 128), np.uint8)]:
        index.add(scene)
    again.__setstate__(index.__getstate__())
    for each in (index, again):
        each.add(scenes[6])
    view = noisy(rng, scenes[2])
    np.testing.assert_array_equal(again.similarity(view), index.similarity(view))
    assert len(again) == 7
