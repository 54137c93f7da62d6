"""`razer reproduce` on synthetic scenes written in the datasets' layouts under the tables' names."""

from __future__ import annotations

import json
import shutil

import pytest

from app.reproduction.published_tables import TABLES
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from tests.support.cli import call

SCENES = {
    "scenenn": ("scenenn", ("011", "016"), "voxels.voxel_size_m=0.04"),
    "replica": ("replica", ("office0", "room1"), "input.stride=1"),
    "scannet200": ("scannet", ("scene0000_00", "scene0001_00"), "voxels.voxel_size_m=0.03"),
}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Two tiny scenes of each dataset; their ids/ images, which those layouts lack, are not needed."""
    folder = tmp_path_factory.mktemp("data")
    for layout, names, _ in SCENES.values():
        for seed, name in enumerate(names):
            room = SyntheticRoom(seed, 12, 96, 72)
            write_recording(room, folder / layout / name, layout, truth=room.truth(0.05))
    return folder


def reproduce(capsys, table, data, out, *more):
    layout, _, setting = SCENES[table]
    code = call("reproduce", table, data / layout, "-o", out, "--no-timeline", "--set", setting, "--json", *more)
    captured = capsys.readouterr()
    return code, json.loads(captured.out.splitlines()[-1]) if code == 0 else captured.err, captured.err


@pytest.mark.parametrize("table", SCENES)
def test_each_layout_gives_a_row_as_long_as_the_papers(data, tmp_path, capsys, table):
    code, result, _ = reproduce(capsys, table, data, tmp_path / "out")
    assert code == 0
    assert len(result["row"]) == len(TABLES[table].columns)
    assert set(result["evaluation"]["scenes"]) == set(SCENES[table][1])
    assert result["evaluation"]["preset"] == TABLES[table].preset
    assert all(seconds > 0 for seconds in result["seconds"].values())
    assert result["stages_ms"]["integrate"] > 0
    absent = set(TABLES[table].scenes) - set(SCENES[table][1])
    assert set(result["failed"]) == absent
    # Surfaces lie on the truth in every layout: poses, scale and axes are right.
    assert result["evaluation"]["surface"]["accuracy_m"] < 0.03


@pytest.mark.full
def test_what_is_mapped_is_not_mapped_again_and_what_is_not_is(data, tmp_path, capsys):
    out = tmp_path / "out"
    reproduce(capsys, "scenenn", data, out)
    first = written(out)
    shutil.rmtree(out / "016")  # as if it had been killed there
    reproduce(capsys, "scenenn", data, out)
    second = written(out)
    assert second["011"] == first["011"]
    assert second["016"] > first["016"]
    reproduce(capsys, "scenenn", data, out, "--set", "voxels.depth_max_m=2.5")
    assert written(out)["011"] > first["011"], "other settings make another map"


def written(out):
    """When each scene's map was written."""
    return {path.parent.name: path.stat().st_mtime_ns for path in out.glob("*/map.npz")}


def test_a_broken_scene_is_named_and_the_others_count(data, tmp_path, capsys):
    broken = tmp_path / "data" / "scenenn"
    shutil.copytree(data / "scenenn", broken)
    shutil.rmtree(broken / "016" / "depth")
    code, result, err = reproduce(capsys, "scenenn", tmp_path / "data", tmp_path / "out")
    assert code == 0
    assert list(result["evaluation"]["scenes"]) == ["011"]
    assert "016" in result["failed"]
    assert "016 is left out" in err


def test_data_without_any_scene_is_one_plain_line(tmp_path, capsys):
    assert call("reproduce", "replica", tmp_path) == 2
    assert "holds none of the scenes" in capsys.readouterr().err
    assert call("reproduce", "replica", tmp_path / "nowhere") == 2
    assert "is not a folder" in capsys.readouterr().err


def test_tables_are_as_wide_as_their_columns_and_means_are_those_of_the_rows():
    for table in TABLES.values():
        assert {len(row) for row in table.rows.values()} == {len(table.columns)}
    for method, row in TABLES["scenenn"].rows.items():
        # The paper's own means, to the digits it prints; Wang's and Li's rows are averaged over other sequences.
        if method not in ("Wang et al.", "Li et al."):
            assert sum(row[:-1]) / 10 == pytest.approx(row[-1], abs=0.5), method


@pytest.mark.full
def test_both_poses_are_two_rows(tmp_path, capsys):
    room = SyntheticRoom(0, 120, 320, 240)
    write_recording(room, tmp_path / "data" / "scenenn" / "016", "scenenn", truth=room.truth(0.05))
    options = ("--poses", "both", "--max-frames", "12")
    code, result, _ = reproduce(capsys, "scenenn", tmp_path / "data", tmp_path / "out", *options)
    assert code == 0
    assert list(result) == ["given", "slam"]
    assert all(list(rows["evaluation"]["scenes"]) == ["016"] for rows in result.values())
    assert result["slam"]["evaluation"]["pose"]["ate_rmse_m"] < 0.05
    assert (tmp_path / "out" / "slam" / "016" / "map.npz").exists()
