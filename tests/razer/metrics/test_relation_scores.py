"""Precision and recall of relations, worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from razer.metrics.relation_scores import RelationScene, count_relations, relation_scores

# A floor (1) of 40 vertices, a second one (2), a table (3), a cup (4), a chair (5) and a speck (6).
TRUTH = np.repeat([1, 2, 3, 4, 5, 6], [40, 40, 30, 10, 20, 2])
TRUE = [(3, "on", 1), (4, "on", 3), (5, "on", 2), (6, "on", 3), (4, "in", 3)]
STUFF = {1: 7, 2: 7}


def counts(predicted, relations, min_region=5):
    return count_relations(RelationScene(TRUTH, np.asarray(predicted), TRUE, relations, STUFF, min_region))


def test_a_perfect_prediction_under_other_ids():
    found = counts(TRUTH + 100, [(a + 100, relation, b + 100) for a, relation, b in TRUE])
    scores = relation_scores([found])
    assert scores["precision"] == scores["recall"] == scores["ends_found"] == 1
    assert scores["by_relation"]["on"]["n_true"] == 3  # the speck is too small to be asked for
    assert scores["by_relation"]["on"]["n_right"] == 4  # but what is said of it is right


def test_floors_are_one_node_and_other_kinds_do_not_count():
    merged = np.where(TRUTH == 2, 1, TRUTH)
    found = counts(merged, [(3, "on", 1), (5, "on", 1), (3, "next to", 5)])
    assert (found.predicted["on"], found.right["on"], found.predicted["next to"]) == (2, 2, 0)


def test_a_relation_of_a_piece_or_of_nothing_is_wrong_and_a_lost_end_lowers_recall_and_ends_found():
    pieces = TRUTH.copy()
    pieces[80:95], pieces[110:120] = 9, 0  # half of the table is another instance, the cup is lost
    found = counts(pieces, [(9, "on", 1), (4, "on", 3), (5, "on", 2)])
    on = relation_scores([found])["by_relation"]["on"]
    assert on["precision"] == pytest.approx(1 / 3)
    assert on["recall"] == on["ends_found"] == pytest.approx(1 / 3)


def test_scenes_are_pooled_and_none_is_none():
    good = counts(TRUTH, TRUE)
    bad = counts(TRUTH, [(3, "on", 4)])
    on = relation_scores([good, bad])["by_relation"]["on"]
    assert (on["precision"], on["recall"]) == (pytest.approx(4 / 5), pytest.approx(3 / 6))
    assert relation_scores([]) is None
