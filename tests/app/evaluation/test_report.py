"""Numbers of an evaluation in words, as one reads them."""

from __future__ import annotations

import pytest

from app.evaluation.report import counts_in_words, format_number, naming_in_words
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation


@pytest.mark.parametrize(
    ("value", "text"),
    [(8.7e-18, "0"), (-1e-9, "0"), (0.00006, "0.0001"), (0.00512, "0.00512"), (1, "1"), (0.93456, "0.9346"),
     (12345.6, "12346"), (None, "-"), (float("nan"), "-")],
)  # fmt: skip
def test_numbers_below_rounding_are_zero(value, text):
    assert format_number(value) == text


def test_counts_say_what_they_mean():
    counts = {"n_true": 36, "n_predicted": 44, "n_matched": 31, "missed": 5, "duplicates": 9, "n_invented": 4}
    result = Evaluation(PRESETS["default"], **counts, n_parts=0, n_uncounted=0)
    assert counts_in_words(result) == (
        "36 true, 44 predicted: 31 matched, 5 missed, 9 pieces of matched ones, 4 on nothing"
    )


def test_names_that_are_right_are_a_share():
    assert naming_in_words({"accuracy": 1.0, "n": 38, "ece": None}) == "names of matched instances: 100.0% of 38 right"
    said = naming_in_words({"accuracy": 0.25, "n": 8, "ece": 0.02})
    assert said == "names of matched instances: 25.0% of 8 right; their probabilities are off by 0.02 on average (ECE)"
