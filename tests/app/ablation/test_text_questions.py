"""Text questions to runs, by a map of three things that answers as it is told to."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.ablation.matched_run import MatchedRun
from app.ablation.text_questions import measure_questions
from razer.map_object import Answer, Hit

NAMES = ("bed", "couch", "chair", "table", "sofa", "whale")  # couch and sofa are one


def text_vectors(names):
    number = {name: i for i, name in enumerate(NAMES)} | {"sofa": 1}
    return np.eye(len(NAMES), dtype=np.float32)[[number[name] for name in names]]


def map_that_answers(scores):
    """scores: {name: (instance, probability)} of the best answers."""

    def query(name, threshold):
        instance, score = scores[name]
        return Answer((Hit(SimpleNamespace(id=instance), score, None),), threshold)

    queries = SimpleNamespace(choices=SimpleNamespace(names=NAMES), knows=lambda name: name in NAMES)
    panoptic = SimpleNamespace(query=query, text_vectors=text_vectors, text_queries=queries)
    return MatchedRun(panoptic, ("bed", "couch"), {1: "bed", 2: "couch", 3: "couch"})


def test_answers_and_presence_are_counted_and_other_names_of_a_class_are_not_absent():
    # Both classes are said to be there; the chair that is not, too; for couch the bed is answered.
    said = {"bed": (1, 0.9), "couch": (1, 0.8), "chair": (2, 0.7), "table": (1, 0.1), "whale": (3, 0.2)}
    result = measure_questions([map_that_answers(said)])
    assert (result["n_there"], result["n_absent"]) == (2, 3)  # no sofa
    assert result["top1"] == 0.5
    assert result["present_precision"] == pytest.approx(2 / 3)
    assert result["present_recall"] == 1.0


def test_of_several_things_of_a_class_any_is_right():
    said = {"bed": (1, 0.9), "couch": (3, 0.2), "chair": (2, 0.1), "table": (1, 0.1), "whale": (3, 0.2)}
    result = measure_questions([map_that_answers(said)])
    assert result["top1"] == 1.0
    assert (result["present_precision"], result["present_recall"]) == (1.0, 0.5)
