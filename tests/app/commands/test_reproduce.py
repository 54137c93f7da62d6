"""`razer reproduce` on synthetic scenes written in the datasets' layouts under the tables' names."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from rich.console import Console

from app.reproduction.component_times import PUBLISHED_MS, component_times
from app.reproduction.published_tables import TABLES
from app.reproduction.report import report
from app.reproduction.reproduce_table import Reproduced
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from razer.frame import Masks
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation
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


SLOW = {"replica", "scannet200"}  # a table of one kind stands for all in the quick tier


@pytest.mark.full
@pytest.mark.parametrize(
    "table", [pytest.param(table, marks=[pytest.mark.full] if table in SLOW else []) for table in SCENES]
)
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
    code, said, _ = reproduce(capsys, "scenenn", data, out, "--set", "voxels.depth_max_m=2.5")
    assert code == 2
    assert "other options" in said
    assert written(out) == second
    (out / "report.json").unlink()
    code, said, _ = reproduce(capsys, "scenenn", data, out)
    assert code == 2
    assert "is there, and of no batch" in said


def written(out):
    """When each scene's map was written."""
    return {path.parent.name: path.stat().st_mtime_ns for path in out.glob("*/map.npz")}


@pytest.mark.full
def test_a_broken_scene_is_named_and_the_others_count(data, tmp_path, capsys):
    broken = tmp_path / "data" / "scenenn"
    shutil.copytree(data / "scenenn", broken)
    shutil.rmtree(broken / "016" / "depth")
    code, result, err = reproduce(capsys, "scenenn", tmp_path / "data", tmp_path / "out")
    assert code == 0
    assert list(result["evaluation"]["scenes"]) == ["011"]
    assert "016" in result["failed"]
    assert "016 failed" in err


def test_data_without_any_scene_is_one_plain_line(tmp_path, capsys):
    assert call("reproduce", "replica", tmp_path) == 2
    assert "holds none of the scenes" in capsys.readouterr().err
    assert call("reproduce", "replica", tmp_path / "nowhere") == 2
    assert "is not a folder" in capsys.readouterr().err
    for scenes in ("room0,", "../room0", "a/b", ""):
        assert call("reproduce", "replica", tmp_path, "--scenes", scenes) == 2
        assert "is no name of a scene" in capsys.readouterr().err
    assert call("reproduce", "replica", tmp_path, "--workers", 0) == 2
    assert "--workers 0: give at least 1" in capsys.readouterr().err


def test_tables_are_as_wide_as_their_columns_and_means_are_those_of_the_rows():
    for table in TABLES.values():
        assert {len(row) for row in (*table.rows.values(), *table.estimated_rows.values())} == {len(table.columns)}
    for method, row in TABLES["scenenn"].rows.items():
        # The paper's own means, to the digits it prints; Wang's and Li's rows are averaged over other sequences.
        if method not in ("Wang et al.", "Li et al."):
            assert sum(row[:-1]) / 10 == pytest.approx(row[-1], abs=0.5), method
    for method, row in TABLES["scenenn"].estimated_rows.items():
        assert sum(row[:-1]) / 10 == pytest.approx(row[-1], abs=0.02), method
    assert TABLES["scenenn"].estimated_rows["RAZER (paper)"][-1] == 62.3


def test_component_times_are_the_papers_and_add_up():
    ours, all_ms = PUBLISHED_MS["RAZER (paper)"], 103.2
    assert sum(ours[:-1]) == pytest.approx(ours[-1]) == pytest.approx(all_ms)
    stages = {"segment": 0.4, "embed": 0.1, "lift": 0.2, "associate": 0.1, "vote": 0.05, "maintain": 0.05, "log": 9}
    timings = {"frames": 10, "stages": {name: {"total_s": total} for name, total in stages.items()}}
    quick = {"frames": 20, "stages": timings["stages"]}
    times = component_times([timings, quick])  # half as long a frame in the second: three quarters on the whole
    assert times == {"2D segmentation": 30, "OBB detection": 15, "OBB tracking": 15, "embedding": 7.5, "all": 67.5}


@pytest.mark.full
def test_what_comes_with_the_table(data, tmp_path, capsys):
    """Retrieval of predicted and of true masks, component times, and the rows that belong to the poses."""
    run = ("reproduce", "scenenn", data / "scenenn", "-o", tmp_path, "--no-timeline", "--scenes", "011", "--json")
    run += ("--segmenter", "tests.app.commands.test_reproduce:Chairs", "--set", "voxels.voxel_size_m=0.04")
    assert call(*run) == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert set(result["retrieval"]) == {"predicted_masks", "given_masks"}
    assert result["components_ms"]["2D segmentation"] > 0
    assert result["poses"] == "auto"
    printed = {}
    for poses in ("given", "slam"):
        report(reproduced(result), TABLES["scenenn"], Console(width=200), poses)
        printed[poses] = capsys.readouterr().out
        for part in ("103.2", "413.5", "2D segmentation = segment", "the truth's masks: class mean"):
            assert part in printed[poses], part
    for poses, parts in {"given": ("given poses", "79.2"), "slam": ("estimated poses", "59.3", "53.27")}.items():
        assert all(part in printed[poses] for part in parts), poses
    assert "79.2" not in printed["slam"]


class Chairs:
    """Calls everything in the middle of the picture a chair."""

    def segment(self, frame):
        mask = np.zeros((1, *frame.depth.shape), bool)
        mask[:, 10:-10, 10:-10] = True
        return Masks(mask, np.ones(1, np.float32), ("chair",))


def reproduced(result):
    """What a result says, under the rows of other poses."""
    evaluation = Evaluation(PRESETS["scenenn"], retrieval=result["evaluation"]["retrieval"])
    numbers = (result["seconds"], result["stages_ms"], result["components_ms"], {})
    return Reproduced(tuple(result["row"]), evaluation, *numbers)


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
    assert [rows["poses"] for rows in result.values()] == ["given", "slam"]
    assert (tmp_path / "out" / "slam" / "016" / "map.npz").exists()
