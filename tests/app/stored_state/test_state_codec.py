"""State goes to JSON and arrays and comes back equal, with what was shared shared; files choose no code."""

from __future__ import annotations

import json
from collections import Counter, OrderedDict, defaultdict, deque
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from app.stored_state.array_packs import PackReader, PackWriter
from app.stored_state.state_codec import Decoder, Encoder, KnownObjects, class_name
from razer.errors import BadInput
from razer.settings import Settings


class Color(Enum):
    RED = 1


class Point(NamedTuple):
    x: int
    y: float


class Limits(Settings):
    low: float = 0.0


class Bounds(Settings):
    limits: Limits = Limits()


@dataclass
class Leaf:
    values: np.ndarray
    names: list[str] = field(default_factory=list)


class Tree:
    def __init__(self, left, right):
        self.left, self.right, self.parent = left, right, None


class Matcher:
    """Holds nothing that is worth keeping."""


class Summed:
    """Keeps its sum alone."""

    def __init__(self, values):
        self.values = values

    def __getstate__(self):
        return sum(self.values)

    def __setstate__(self, total):
        self.values = [total]


BOUNDS = Bounds()
KNOWN = KnownObjects.of((Color, Point, Leaf, Tree, Summed), BOUNDS, {Matcher: Matcher})


def packed(folder, value):
    writer = PackWriter(folder, "state")
    writer.begin()
    tree = Encoder(KNOWN, writer).encode(value)
    writer.finish()
    return json.loads(json.dumps(tree))


def unpacked(folder, tree):
    return Decoder(KNOWN, PackReader(folder, "state")).decode(tree)


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inner: (
        st.lists(inner)
        | st.tuples(inner, inner)
        | st.dictionaries(st.integers() | st.text() | st.tuples(st.integers()), inner)
        | st.lists(inner).map(deque)
        | st.sets(st.integers())
        | st.frozensets(st.text())
    ),
    max_leaves=20,
)


@settings(max_examples=100, deadline=None)
@given(value=PLAIN)
def test_plain_values_come_back_as_they_were(value, tmp_path_factory):
    folder = tmp_path_factory.mktemp("packs")
    back = unpacked(folder, packed(folder, value))
    assert back == value
    assert type(back) is type(value)


@pytest.mark.parametrize("dtype", ["f4", "f8", "i2", "i4", "i8", "u1", "b1", "u8"])
@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 0, 3), (4, 3, 2)])
def test_arrays_come_back_bit_for_bit(tmp_path, dtype, shape):
    array = np.random.default_rng(0).integers(0, 2**31, shape).astype(dtype)
    back = unpacked(tmp_path, packed(tmp_path, array))
    assert (back.dtype, back.shape) == (array.dtype, array.shape)
    np.testing.assert_array_equal(back, array)
    if back.size:
        back[...] = 0  # it may be changed


def test_arrays_in_other_orders_and_tensors_and_scalars(tmp_path):
    turned = np.arange(6.0).reshape(2, 3).T
    value = [turned, torch.arange(4, dtype=torch.int16), np.float32(0.1), np.int64(7), np.nan, float("inf")]
    back = unpacked(tmp_path, packed(tmp_path, value))
    np.testing.assert_array_equal(back[0], turned)
    assert torch.equal(back[1], value[1])
    assert (back[2].dtype, back[2], back[3]) == (np.float32, np.float32(0.1), 7)
    assert np.isnan(back[4])
    assert back[5] == float("inf")


def test_dictionaries_of_all_kinds_keep_kind_and_order(tmp_path):
    counts = defaultdict(set, {2: {1}, 1: set()})
    value = [counts, Counter("abca"), OrderedDict([(3, "c"), (1, "a")]), {2: "b", 1: "a"}]
    back = unpacked(tmp_path, packed(tmp_path, value))
    assert back == value
    assert [list(each) for each in back] == [list(each) for each in value]
    assert [type(each) for each in back] == [type(each) for each in value]
    back[0][9].add(4)
    assert back[0][9] == {4}


def test_what_is_shared_stays_shared(tmp_path):
    leaf = Leaf(np.zeros(3), ["a"])
    tree = Tree(leaf, [leaf, leaf.names, leaf.values])
    tree.parent = tree
    back = unpacked(tmp_path, packed(tmp_path, tree))
    assert back.parent is back
    assert back.right[0] is back.left
    assert back.right[1] is back.left.names
    assert back.right[2] is back.left.values


def test_classes_with_a_state_of_their_own_enums_named_tuples_and_those_that_hold_nothing(tmp_path):
    value = [Summed([1, 2, 3]), Color.RED, Point(1, 0.5), Matcher(), BOUNDS, BOUNDS.limits]
    summed, color, point, matcher, *bounds = unpacked(tmp_path, packed(tmp_path, value))
    assert summed.values == [6]
    assert (color, point) == (Color.RED, Point(1, 0.5))
    assert type(matcher) is Matcher
    assert bounds[0] is BOUNDS
    assert bounds[1] is BOUNDS.limits


class Stranger:
    pass


def test_a_class_that_is_not_known_is_refused_on_both_ways(tmp_path):
    with pytest.raises(TypeError, match="Stranger"):
        packed(tmp_path, [Stranger()])
    for name in (class_name(Stranger), "os.system", "builtins.eval", "subprocess.Popen"):
        for tree in (["object", name, ["dict", [], 1], 0], ["made", name, 0], ["named", name, ["ls"], 0]):
            with pytest.raises(BadInput, match="damaged"):
                unpacked(tmp_path, tree)


TAGS = ["object", "array", "tensor", "bytes", "dict", "same", "given", "made", "named", "enum", "default"]
NAMES = [class_name(kind) for kind in (Leaf, Color, Point, Matcher)]
JSON = st.recursive(
    st.none() | st.integers(-5, 5) | st.floats() | st.text(max_size=3) | st.sampled_from([*TAGS, *NAMES]),
    lambda inner: st.lists(inner, max_size=5),
    max_leaves=15,
)


@settings(max_examples=200, deadline=None)
@given(tree=st.lists(JSON, min_size=1))
def test_a_tree_that_was_made_up_is_bad_input_or_a_value_and_never_another_error(tree, tmp_path_factory):
    with suppress(BadInput):
        unpacked(tmp_path_factory.getbasetemp(), tree)


def test_an_array_of_objects_is_refused(tmp_path):
    tree = packed(tmp_path, np.zeros(2))
    tree[5] = "|O"
    with pytest.raises(BadInput, match="damaged"):
        unpacked(tmp_path, tree)
