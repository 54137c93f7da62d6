"""Keyframes by appearance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slam.backend.place_recognition import PlaceRecognition
from slam.frontend.features import Features


def described(rng, n=200):
    descriptors = rng.integers(0, 256, (n, 32)).astype(np.uint8)
    return Features(np.zeros((n, 2)), descriptors, np.ones(n), np.ones(n), np.zeros(n))


def test_a_place_seen_again_is_the_most_alike(rng):
    places, scenes = PlaceRecognition(), [described(rng) for _ in range(70)]
    for scene in scenes:
        places.add(scene)
    flips = np.packbits(rng.random((200, 256)) < 0.05, axis=1)
    revisited = replace(scenes[17], descriptors=scenes[17].descriptors ^ flips)
    similarity = places.similarity(revisited)
    assert similarity.shape == (70,)
    assert similarity.argmax() == 17
    assert places.similarity(described(rng)).max() < similarity[17]
