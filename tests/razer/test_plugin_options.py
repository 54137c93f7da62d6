"""Options that a part does not take are said with those that it has, before anything is built."""

from __future__ import annotations

import pytest

from razer.errors import BadInput
from razer.models import make_embedder, make_segmenter


@pytest.mark.parametrize(
    ("make", "name", "options", "message"),
    [
        (make_segmenter, "yolo", {}, "missing 1 option: 'weights'"),
        (make_segmenter, "prompted", {}, "missing 2 options: 'weights' and 'words'"),
        (make_segmenter, "yolo", {"weights": 3}, "weights = 3 should be a text"),
        (make_segmenter, "oracle", {"seed": "a"}, "seed = 'a' should be a whole number"),
        (make_segmenter, "oracle", {"seed": "7"}, "seed = '7' should be a number"),
        (make_segmenter, "oracle", {"nois": "full"}, "there is no 'nois', its options are noise"),
        (make_embedder, "appearance", {"x": 1}, "there is no 'x', it has none"),
    ],
)
def test_wrong_options_are_refused_without_names_of_code(make, name, options, message):
    with pytest.raises(BadInput, match="does not take these options") as refused:
        make(name, options)
    assert message in str(refused.value)
    assert not any(word in str(refused.value) for word in ("__init__", "()", "keyword", "argument", "os.PathLike"))


def test_options_of_the_right_kind_are_taken():
    make_segmenter("oracle", {"noise": "full", "seed": 3})
