"""`razer ablate`: all variants see the same frames, and a part that is switched off is missed."""

from __future__ import annotations

import json
from typing import get_args

import pytest

from app.ablation.mapper_variants import COLUMNS, VARIANTS
from app.ablation.perceived_walk import PerceivedWalk
from app.settings.config_file import read_config
from app.settings.options import RunOptions
from app.settings.oracle_options import OracleErrors, oracle_options
from app.settings.presets import DEPARTURES
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig
from razer.detection.perception import Perception
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.profiles.table import PROFILES
from razer.models.oracle.segmenter import OracleSegmenter
from tests.support.cli import call


@pytest.mark.full
def test_a_line_of_numbers_for_each_variant_and_seed(capsys):
    chosen = ("as is", "map: no consensus")
    code = call("ablate", "--scene", "tabletop", "--seeds", "1", "--frames", "24", "--variants", *chosen, "--json")
    assert code == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    (row,) = result["variants"]
    assert list(row) == list(chosen)
    assert all(set(numbers) == {*COLUMNS, "instances"} for numbers in row.values())
    assert row["as is"]["ap50"] > 0.3
    # Masks split for five frames at a time start tracks that nothing joins again.
    assert row["map: no consensus"]["instances"] > row["as is"]["instances"]


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


@pytest.mark.full
def test_so_few_frames_that_nothing_is_named_are_one_plain_line(capsys):
    code = call("ablate", "--scene", "tabletop", "--seeds", "1,1", "--frames", "2", "--variants", "as is")
    assert (code, capsys.readouterr().err.splitlines()[-1][:7]) == (2, "razer: ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--seeds", "one"), "whole numbers"),
        (("--seeds", "1,1", "--workers", "0"), "--workers 0: give at least 1"),
        (("--stride", "2,0"), "whole numbers from 1"),
        (("--stride", "fast"), "--stride fast"),
        (("--variants", "no walls"), "choose from"),
        (("--noise", "detector", "--frames", "2"), "needs option table"),
        (("--noise", "sam", "--exemplars", "/nowhere.npz", "--frames", "2"), "/nowhere.npz"),
    ],
)
def test_wrong_usage_is_one_plain_line(capsys, arguments, message):
    assert call("ablate", *arguments) == 2
    assert message in capsys.readouterr().err


def test_the_paper_comes_first_each_departure_alone_and_ours_last():
    names = list(VARIANTS)
    assert (names[0], names[-1]) == ("the paper", "as is")
    assert {name: VARIANTS[name] for name in DEPARTURES} == dict(DEPARTURES)
    assert read_config(None, (), VARIANTS["the paper"]) == read_config(None, (), {}, preset="paper")
    assert VARIANTS["as is"] == {}


def test_variants_with_the_same_perception_share_it(tmp_path):
    room = SyntheticRoom(0, 3, 160, 120)
    walk = PerceivedWalk(tmp_path, (OracleSegmenter("none"), OracleEmbedder("none")), MapperConfig())
    walk.record(room[i] for i in range(3))
    files = {name: walk.perceived(read_config(None, (), changes)).path.name for name, changes in DEPARTURES.items()}
    apart = {name for name, file in files.items() if file == "other"}
    assert apart == {name for name in DEPARTURES if name.startswith(("masks", "lifting"))}
    assert [o.frame.index for o in walk.perceived(MapperConfig())] == [0, 1, 2]
    # What waited on disk is what would have been perceived at once.
    config = read_config(None, (), {"masks.shrink_pixels": 0})
    perception = Perception(config, OracleSegmenter("none"), OracleEmbedder("none"))
    for index, stored in enumerate(walk.perceived(config)):
        fresh = perception.observe(room[index])
        pixels = [[d.pixels.tolist() for d in o.lifted.detections] for o in (stored, fresh)]
        assert pixels[0] == pixels[1]
        assert len(pixels[0]) > 0


@pytest.mark.full
@pytest.mark.parametrize("noise", ["sam", "detector", "panoptic"])
def test_masks_and_vectors_of_profiles_are_mapped(capsys, real_data, noise):
    options = ("--scene", "tabletop", "--seeds", "1", "--frames", "24", "--variants", "as is", "--noise", noise)
    assert call("ablate", *options, "--exemplars", real_data / "clip-vit-b32" / "lvis.npz", "--json") == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert result["noise"] == noise
    assert 3 < result["variants"][0]["as is"]["instances"] < 300


def test_each_kind_of_errors_is_options_of_both_models(tmp_path):
    table = tmp_path / "exemplars.npz"
    assert oracle_options("full") == ({"noise": "full"}, {"noise": "full"})
    assert oracle_options("sam") == ({"profile": "sam"}, {"noise": "full"})
    assert oracle_options("detector", table) == ({"profile": "detector"}, {"profile": "clip", "table": str(table)})
    assert oracle_options("none", table) == ({"noise": "none"}, {"profile": "clip", "table": str(table)})
    profiles = {errors for errors in get_args(OracleErrors) if "profile" in oracle_options(errors)[0]}
    assert profiles == set(PROFILES)
    config = RunOptions(oracle="sam").read()
    assert (config.segmenter.name, config.embedder.name) == ("oracle", "oracle")
    assert config.segmenter.options == {"profile": "sam"}
