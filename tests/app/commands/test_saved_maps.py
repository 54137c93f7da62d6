"""Verbs take a folder that `PanopticMap.save` wrote: without a trajectory, without a timeline."""

from __future__ import annotations

import json
import shutil

import pytest

import razer
from data_tools import write_recording
from data_tools.synthetic.synthetic_room import SyntheticRoom
from tests.support.cli import razer as call


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """(folder of a saved map, its recording with the truth)."""
    place = tmp_path_factory.mktemp("saved")
    room = SyntheticRoom(0, 12, 160, 120)
    write_recording(room, place / "recording", truth=room.truth(0.05), lossless=True)
    config = razer.MapperConfig.model_validate({"voxels": {"voxel_size_m": 0.05}})
    mapper = razer.Mapper(config, "oracle", "oracle")
    for index in range(len(room)):
        mapper.step(room[index])
    mapper.finish().save(place / "map")
    return place / "map", place / "recording"


@pytest.fixture
def folder(saved, tmp_path):
    """A copy of the saved map, to be written to."""
    return shutil.copytree(saved[0], tmp_path / "map")


def test_it_is_queried(capsys, folder):
    code, out, err = call(capsys, "query", folder, "a chair", "--json")
    assert code == 0, err
    hits = json.loads(out)["hits"]
    assert hits
    assert {hit["class"] for hit in hits} == {"chair"}


def test_it_is_labelled(capsys, folder):
    code, _, err = call(capsys, "label", folder, "--vocabulary", "nyu40")
    assert code == 0, err
    assert (folder / "scene_graph.json").is_file()


def test_it_is_evaluated(capsys, saved, folder):
    code, out, err = call(capsys, "eval", folder, "--truth", saved[1], "--json")
    assert code == 0, err
    assert json.loads(out)["class_agnostic"]["ap50"] > 0.5


def test_it_is_drawn_and_has_no_timeline(capsys, folder, tmp_path):
    assert call(capsys, "view", folder, "--picture", tmp_path / "map.png")[0] == 0
    assert (tmp_path / "map.png").stat().st_size > 1000
    code, _, err = call(capsys, "view", folder)
    assert code == 2
    assert f"{folder} has no timeline" in err


@pytest.mark.full
def test_two_are_compared_as_they_lie(capsys, saved, folder):
    code, out, err = call(capsys, "compare", saved[0], folder, "--json")
    assert code == 0, err
    result = json.loads(out)
    assert result["pose"] is None
    assert result["instances"]["missed"] == result["instances"]["extra"] == []
    assert result["surface"]["fscore_2cm"] == pytest.approx(1.0)
    assert "compared as they lie" in err
    code, out, _ = call(capsys, "compare", saved[0], folder)
    assert code == 0
    assert "A from B" not in out


def test_one_is_not_compared_with_the_truth_without_a_trajectory(capsys, saved, folder):
    code, _, err = call(capsys, "compare", saved[0], folder, "--truth", saved[1])
    assert code == 2
    assert "has no trajectory.txt" in err
