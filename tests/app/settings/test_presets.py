"""`--preset paper`: every departure taken back, overridden by a file and by --set."""

from __future__ import annotations

import json

import numpy as np
import pytest

from app.settings.config_file import read_config
from app.settings.presets import DEPARTURES, PAPER
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.errors import BadInput
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.storage.settings_list import list_settings
from tests.support.cli import razer


def test_each_departure_changes_what_it_names_and_nothing_else():
    default = {setting.name: setting.value for setting in list_settings(read_config(None, (), {}))}
    for name, changes in DEPARTURES.items():
        changed = {setting.name: setting.value for setting in list_settings(read_config(None, (), changes))}
        assert {key for key in default if changed[key] != default[key]} == set(changes), name


def test_the_paper_is_all_departures_at_once():
    assert dict(PAPER) == {key: value for changes in DEPARTURES.values() for key, value in changes.items()}
    assert sum(len(changes) for changes in DEPARTURES.values()) == len(PAPER), "no setting belongs to two"
    assert read_config(None, (), {}, preset="paper") == read_config(None, (), PAPER)


def test_the_preset_comes_first_then_the_file_then_set(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("[association]\ngate = 0.9\njoin = true\n[bank]\noutlier = 0.1\n")
    config = read_config(file, ["association.gate=1.5"], {"bank.outlier": 0.3}, preset="paper")
    assert (config.association.gate, config.association.join, config.bank.outlier) == (1.5, True, 0.3)
    assert config.association.geometry_distance == "paper", "a section of the file leaves the rest of it as it was"
    assert config.maintenance.label_votes == "box"


def test_config_prints_the_preset(capsys):
    code, out, _ = razer(capsys, "config", "--preset", "paper", "--set", "association.join=true", "--json")
    values = {setting["name"]: setting["value"] for setting in json.loads(out)}
    assert code == 0
    assert {name: values[name] for name in PAPER} == {**PAPER, "association.join": True}


@pytest.mark.parametrize("verb", [("config",), ("run", "nowhere", "-o", "out"), ("demo",), ("bench",)])
def test_an_unknown_preset_is_one_plain_line(capsys, verb, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = razer(capsys, *verb, "--preset", "papyrus")
    assert (code, out) == (2, "")
    assert err == "razer: --preset papyrus: there is no such preset; choose from paper\n"
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(BadInput):
        read_config(None, (), {}, preset="papyrus")


def test_a_room_is_mapped_the_papers_way():
    config = read_config(None, ["voxels.voxel_size_m=0.05", "reintegration.enabled=true"], {}, preset="paper")
    mapper = Mapper(config, OracleSegmenter("full"), OracleEmbedder("full"))
    room = SyntheticRoom(0, 5, 160, 120)
    frames = [room[index] for index in range(5)]
    steps = [mapper.step(frame) for frame in frames]
    assert {decision.outcome for step in steps for decision in step.decisions} == {"matched", "born"}
    assert [step.fused for step in steps] == [()] * 5
    found = {o.id: o.n_voxels for o in mapper.snapshot().objects}
    assert set(found) == {track.id for track in mapper.tracks}, "a track is an instance at once"
    aside = np.eye(4)
    aside[0, 3] = 0.5
    mapper.move({frame.index: aside @ frame.pose for frame in frames})
    moved = mapper.finish()
    assert len(moved.objects) > 3
    assert {o.id for o in moved.objects} <= set(found)
    box_voters = {int(i) for i in np.unique(moved.mesh.instances)} - {0}
    assert len(box_voters) > 3
