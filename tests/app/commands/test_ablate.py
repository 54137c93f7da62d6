"""`razer ablate`: all variants see the same frames, and a part that is switched off is missed."""

from __future__ import annotations

import json

import pytest

from app.ablation.mapper_variants import COLUMNS, VARIANTS
from app.settings.config_file import read_config
from tests.support.cli import call


@pytest.mark.full
def test_a_line_of_numbers_for_each_variant_and_seed(capsys):
    chosen = ("as is", "no fusion of duplicates")
    code = call("ablate", "--scene", "tabletop", "--seeds", "1", "--frames", "24", "--variants", *chosen, "--json")
    assert code == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    (row,) = result["variants"]
    assert list(row) == list(chosen)
    assert all(set(numbers) == set(COLUMNS) for numbers in row.values())
    assert row["as is"]["ap50"] > 0.3
    # Masks split for five frames at a time start tracks that nothing joins again.
    assert row["no fusion of duplicates"]["instances"] > row["as is"]["instances"]


@pytest.mark.full
def test_strides_share_the_walk_and_the_truth(capsys):
    options = ("--scene", "tabletop", "--seeds", "1", "--frames", "12", "--variants", "as is")
    assert call("ablate", *options, "--stride", "1,3", "--json") == 0
    both = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert both["strides"] == [1, 3]
    assert [part["stride"] for part in both["by_stride"]] == [1, 3]
    assert both["variants"] == both["by_stride"][0]["variants"]
    assert call("ablate", *options, "--stride", "3", "--json") == 0
    alone = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert alone["by_stride"][0] == both["by_stride"][1], "a stride does not depend on which others are measured"
    every, third = (part["variants"][0]["as is"] for part in both["by_stride"])
    assert third["instances"] < every["instances"]
    # What the frames left out show is still asked for: of one truth more is missed.
    assert third["missed"] > every["missed"]
    assert call("ablate", *options, "--stride", "3") == 0
    assert "stride" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--seeds", "one"), "whole numbers"),
        (("--stride", "2,0"), "whole numbers from 1"),
        (("--stride", "fast"), "--stride fast"),
        (("--variants", "no walls"), "choose from"),
    ],
)
def test_wrong_usage_is_one_plain_line(capsys, arguments, message):
    assert call("ablate", *arguments) == 2
    assert message in capsys.readouterr().err


def test_every_variant_is_a_valid_setting_after_perception():
    base = read_config(None, (), {})
    for name, changes in VARIANTS.items():
        changed = read_config(None, (), changes)
        assert (changed == base) == (name == "as is")
        assert (changed.voxels, changed.masks, changed.lifting) == (base.voxels, base.masks, base.lifting)
