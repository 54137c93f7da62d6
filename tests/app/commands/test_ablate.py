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


@pytest.mark.parametrize(
    ("arguments", "message"), [(("--seeds", "one"), "whole numbers"), (("--variants", "no walls"), "choose from")]
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
