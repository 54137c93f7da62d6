"""Edits as they are asked for: what is one, and what is refused before any map is looked at."""

from __future__ import annotations

import json

import pytest

from razer.edits.edit import edit_of
from razer.errors import BadInput
from tests.support.edited_maps import plane

GOOD = [
    {"kind": "rename", "instance": 12, "name": "office chair"},
    {"kind": "relabel", "instance": 12, "class": "floor"},
    {"kind": "merge", "instances": [3, 1, 2]},
    {"kind": "delete", "instance": 7},
    {"kind": "split", "instance": 7, "region": plane(1, 0, 0, 2.5), "new": 8},
    {"kind": "move_border", "from": 1, "to": 2, "region": plane(0, 1, 0, 0)},
    {
        "kind": "split",
        "instance": 7,
        "region": {"lasso": {"clip_from_world": [1.0] * 16, "polygon": [[0, 0], [1, 0], [0, 1]]}},
    },
]


@pytest.mark.parametrize("content", GOOD, ids=lambda content: content["kind"])
def test_an_edit_goes_through_json_and_comes_back(content):
    edit = edit_of(content)
    assert edit_of(json.loads(json.dumps(edit.to_json()))) == edit
    assert edit.to_json() | content == json.loads(json.dumps(edit.to_json()))
    assert edit.touched == tuple(
        content.get("instances") or [content[name] for name in ("instance", "from", "to") if name in content]
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"kind": "paint", "instance": 1}, "paint"),
        ({}, "kind"),
        ({"kind": "rename", "instance": 1}, "name"),
        ({"kind": "rename", "instance": 0, "name": "x"}, "instance"),
        ({"kind": "rename", "instance": 1.5, "name": "x"}, "instance"),
        ({"kind": "rename", "instance": True, "name": "x"}, "instance"),
        ({"kind": "rename", "instance": 2**31, "name": "x"}, "instance"),
        ({"kind": "rename", "instance": 1, "name": "   "}, "name"),
        ({"kind": "rename", "instance": 1, "name": "a\x1b[31m"}, "name"),
        ({"kind": "rename", "instance": 1, "name": "x" * 81}, "name"),
        ({"kind": "rename", "instance": 1, "name": "x", "colour": "red"}, "colour"),
        ({"kind": "merge", "instances": [1]}, "instances"),
        ({"kind": "merge", "instances": [1, 2, 1]}, "once"),
        ({"kind": "split", "instance": 1, "region": {}}, "plane or a lasso"),
        ({"kind": "split", "instance": 1, "region": plane(0, 0, 0, 1)}, "normal"),
        ({"kind": "split", "instance": 1, "region": plane(float("nan"), 0, 0, 1)}, "normal"),
        ({"kind": "split", "instance": 1, "region": plane(1, 0, 0, 1) | {"lasso": None, "x": 1}}, "x"),
        ({"kind": "split", "instance": 1, "region": {"lasso": {"clip_from_world": [1.0] * 15, "polygon": []}}}, "clip"),
    ],
)
def test_what_is_no_edit_is_refused_in_one_line_that_names_the_field(content, message):
    with pytest.raises(BadInput, match=message) as refused:
        edit_of(content)
    assert "\n" not in str(refused.value)


def test_a_name_is_kept_with_single_spaces():
    assert edit_of({"kind": "rename", "instance": 1, "name": "  grandma's \n chair "}).name == "grandma's chair"
