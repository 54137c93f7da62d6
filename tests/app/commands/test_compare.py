"""`razer compare`: a run beside a moved, a poorer and a disturbed copy of itself, and what cannot be compared."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
import rerun as rr
from scipy.spatial.transform import Rotation

from app.comparison.compare_runs import compare_runs
from app.timeline.viewer import rerun_viewer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from razer.metrics.presets import PRESETS
from razer.storage.ply import read_mesh_ply, write_mesh_ply
from tests.support.changed_runs import MOTION, copy_with, moved_copy, without
from tests.support.cli import call

N_FRAMES = 24
RULES = PRESETS["default"]
FILES = {"compare.png", "compare.json", "trajectories.png", "errors.png", "instances.png", "compare.rrd"}
POSE_KEYS = {
    "ate_rmse_m", "rotation_rmse_deg", "rpe_trans_m", "rpe_rot_deg", "rpe_second_trans_m", "rpe_second_rot_deg",
    "compared", "tracked_a", "tracked_b", "a_from_b", "a_from_b_by_positions", "aligned_by", "degenerate",
    "truth_from_a", "truth_from_b",
}  # fmt: skip
PAIR_KEYS = {
    "a", "b", "class_a", "class_b", "iou", "center_distance_m", "center_a_m", "center_b_m", "extent_a_m",
    "extent_b_m", "cosine",
}  # fmt: skip


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare") / "room"
    recording = SyntheticRoom(0, N_FRAMES, 128, 96)
    write_folder(recording, folder, truth=recording.truth(spacing_m=0.05))
    return folder


@pytest.fixture(scope="module")
def run(room):
    folder = room.with_name("run")
    models = ("--segmenter", "oracle", "--embedder", "oracle", "--no-timeline")
    assert call("run", room, "-o", folder, *models, "--set", "voxels.voxel_size_m=0.05", "--device", "cpu") == 0
    return folder


@pytest.fixture(scope="module")
def moved(run):
    """The same run as another system would have it, in a world of its own."""
    return moved_copy(run, run.with_name("moved"))


def numbers_in(value):
    if isinstance(value, dict):
        return [number for part in value.values() for number in numbers_in(part)]
    return [value] if isinstance(value, int | float) else []


# What two runs have in common


def test_a_moved_run_is_brought_back_and_everything_matches(run, moved):
    result = compare_runs(run, moved, None, RULES).as_json()
    np.testing.assert_allclose(result["pose"]["a_from_b"], np.linalg.inv(MOTION), atol=1e-6)
    np.testing.assert_allclose(result["pose"]["a_from_b_by_positions"], np.linalg.inv(MOTION), atol=1e-6)
    assert result["pose"]["degenerate"] is None
    assert result["alignment"]["aligned_by"] == "poses"  # the surfaces fit already
    assert not result["alignment"]["refinement"]["kept"]
    assert result["pose"]["ate_rmse_m"] < 1e-6
    assert result["pose"]["rpe_rot_deg"] < 1e-5
    assert result["pose"]["tracked_a"] == result["pose"]["tracked_b"] == 1.0
    instances = result["instances"]
    assert len(instances["matched"]) > 10
    assert instances["missed"] == instances["extra"] == []
    for pair in instances["matched"]:
        assert pair["a"] == pair["b"]
        assert pair["class_a"] == pair["class_b"] is not None
        assert pair["iou"] > 0.97
        assert pair["center_distance_m"] < 1e-4
        assert pair["extent_a_m"] == pair["extent_b_m"]
        assert pair["cosine"] == pytest.approx(1, abs=1e-5)
    assert result["surface"]["accuracy_m"] < 1e-5
    assert result["surface"]["fscore_2cm"] == 1.0
    assert result["a"] is result["b"] is result["delta"] is None


def without_poses(content):
    """An evaluation without the errors of its poses."""
    scenes = {name: {**scene, "pose": None} for name, scene in content["scenes"].items()}
    return {**content, "pose": None, "scenes": scenes}


@pytest.mark.full
def test_against_the_truth_both_sides_are_alike(room, run, moved, capsys):
    capsys.readouterr()
    assert call("compare", run, moved, "--truth", room, "--json", "-o", run.with_name("truth")) == 0
    result = json.loads(capsys.readouterr().out)
    assert call("eval", run, "--truth", room, "--json") == 0
    evaluated = json.loads(capsys.readouterr().out)
    # Aligned to the truth, even given poses can differ from it; `eval` takes them as they are.
    assert without_poses(result["a"]) == without_poses(evaluated)
    assert evaluated["pose"] is None
    assert result["pose"]["truth_from_a"] == np.eye(4).tolist()
    np.testing.assert_allclose(result["pose"]["truth_from_b"], np.linalg.inv(MOTION), atol=1e-6)
    assert result["b"]["pose"]["ate_rmse_m"] < 1e-6
    assert result["a"]["class_agnostic"]["ap50"] > 0.5
    deltas = numbers_in(result["delta"])
    assert len(deltas) > 50
    # Vertices that lie equally far from two instances may go either way.
    assert max(map(abs, deltas)) < 0.05
    assert result["delta"]["surface"]["accuracy_m"] == pytest.approx(0, abs=1e-5)
    assert result["delta"]["retrieval"]["given_masks"]["class_mean"] == pytest.approx(0, abs=0.05)


def test_an_instance_that_one_run_lacks_is_missed_or_extra(run, tmp_path):
    largest = max(json.loads((run / "instances.json").read_text())["instances"], key=lambda item: item["n_vertices"])
    poorer = without(run, tmp_path / "poorer", largest["id"])
    there = compare_runs(run, poorer, None, RULES).as_json()["instances"]
    back = compare_runs(poorer, run, None, RULES).as_json()["instances"]
    assert [item["id"] for item in there["missed"]] == [item["id"] for item in back["extra"]] == [largest["id"]]
    assert there["missed"][0]["class"] == largest["class"]
    assert there["missed"][0]["center_m"] == pytest.approx(largest["center"])
    assert there["extra"] == back["missed"] == []
    assert len(there["matched"]) == len(back["matched"])


def test_disturbed_positions_lost_frames_and_their_errors(run, tmp_path):
    rng = np.random.default_rng(0)
    noise = rng.normal(scale=0.03, size=(N_FRAMES, 3))
    kept = np.delete(np.arange(N_FRAMES), [10, 11, 12])
    other = copy_with(run, tmp_path / "b", lambda s, p, r: (s[kept], (p + noise)[kept], r[kept]))
    pose = compare_runs(run, other, None, RULES).as_json()["pose"]
    positions = np.loadtxt(run / "trajectory.txt")[kept, 1:4]
    middle, disturbed = positions - positions.mean(axis=0), positions + noise[kept]
    _, length = Rotation.align_vectors(middle, disturbed - disturbed.mean(axis=0))
    assert pose["ate_rmse_m"] == pytest.approx(length / np.sqrt(len(kept)), rel=1e-6)
    assert pose["rpe_rot_deg"] == pytest.approx(0, abs=1e-5)
    assert pose["compared"] == len(kept)
    assert pose["tracked_a"] == 1
    assert pose["tracked_b"] == pytest.approx(len(kept) / N_FRAMES)


def test_a_nearly_flat_path_does_not_turn_the_map(run, moved, tmp_path):
    """Positions that drift by 3 cm on a path of 30, 11 and 1 cm say next to nothing of how maps lie to each other."""
    t = np.linspace(0, 2 * np.pi, N_FRAMES)
    path = np.stack([0.42 * np.sin(t), 0.155 * np.cos(2 * t), 0.014 * np.cos(5 * t)], axis=1)
    drift = np.stack([0 * t, 0 * t, 0.04 * np.cos(2 * t)], axis=1)
    turned, shift = MOTION[:3, :3], MOTION[:3, 3]
    one = copy_with(run, tmp_path / "one", lambda s, p, r: (s, path, r))
    other = copy_with(moved, tmp_path / "other", lambda s, p, r: (s, (path + drift) @ turned.T + shift, r))
    result = compare_runs(one, other, None, RULES)
    content = result.as_json()

    def turn_deg(transform):
        return np.degrees(Rotation.from_matrix((np.array(transform) @ MOTION)[:3, :3]).magnitude())

    assert turn_deg(content["pose"]["a_from_b_by_positions"]) > 5
    assert "nearly flat" in content["pose"]["degenerate"]
    assert any("nearly flat" in note and "ATE" in note for note in result.notes)
    assert content["surface"]["fscore_5cm"] > 0.99
    assert len(content["instances"]["matched"]) > 10
    assert content["pose"]["rotation_rmse_deg"] < 1
    # The surfaces take back what drift did to the mean of the poses.
    alignment = content["alignment"]
    assert alignment["aligned_by"] == "poses and surfaces"
    assert alignment["a_from_b"] == content["pose"]["a_from_b"] != alignment["a_from_b_by_poses"]
    np.testing.assert_allclose(np.array(alignment["a_from_b"]) @ MOTION, np.eye(4), atol=0.002)
    refinement = alignment["refinement"]
    assert refinement["kept"]
    assert refinement["fit_after_m"] < 0.2 * refinement["fit_before_m"]
    assert 0.001 < refinement["moved_m"] < 0.05


def test_a_camera_that_stands_still_is_aligned_by_where_it_looks(run, moved, tmp_path):
    def still(stamps, positions, rotations):
        return stamps, positions[:1] + np.zeros((len(stamps), 1)), rotations

    one, other = copy_with(run, tmp_path / "one", still), copy_with(moved, tmp_path / "other", still)
    result = compare_runs(one, other, None, RULES)
    np.testing.assert_allclose(result.pose.truth_from_estimate, np.linalg.inv(MOTION), atol=1e-6)
    assert result.as_json()["pose"]["aligned_by"] == "orientations"
    assert "hardly moved" in result.as_json()["pose"]["degenerate"]
    assert any("orientations helped" in note for note in result.notes)


def test_empty_maps_are_compared_by_their_poses(run, tmp_path):
    empty = tmp_path / "empty"
    shutil.copytree(run, empty)
    mesh = read_mesh_ply(run / "mesh.ply")
    nothing = type(mesh)(mesh.vertices[:0], mesh.colors[:0], mesh.instances[:0], mesh.triangles[:0])
    write_mesh_ply(empty / "mesh.ply", nothing)
    result = compare_runs(run, empty, None, RULES)
    assert result.surface is None
    assert result.instances.matched == result.instances.extra == ()
    assert any("the map is empty" in note for note in result.notes)
    assert call("compare", run, empty, "-o", tmp_path / "out") == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES


# Files and the screen


def test_files_tables_and_what_else_lies_there(run, moved, capsys, monkeypatch):
    out = moved / "compare"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    (out / "compare.json").write_text("old")
    capsys.readouterr()
    assert call("compare", run, moved) == 0
    text = capsys.readouterr().out
    for words in (
        "A: run",
        "B: moved",
        f"A: {N_FRAMES} of {N_FRAMES} frames used",
        "maps aligned by full poses; not refined on the surfaces",
        "A from B, of the maps:",
        "A from B, of the positions alone (ATE):",
        "B against A",
        "ATE RMSE, m",
        "instances in both",
        "chair",
        "0 missed",
        "0 ext",
        f"picture: {out / 'compare.png'}",
    ):
        assert words in text
    assert {path.name for path in out.iterdir()} == FILES | {"mine.txt"}

    def refuse(constant):
        raise AssertionError(f"{constant} in JSON")

    content = json.loads((out / "compare.json").read_text(), parse_constant=refuse)
    assert set(content) == {
        "format", "run_a", "run_b", "preset", "a", "b", "delta", "frames", "alignment", "pose", "surface", "instances",
        "notes", "warnings",
    }  # fmt: skip
    assert set(content["pose"]) == POSE_KEYS
    assert all(set(pair) == PAIR_KEYS for pair in content["instances"]["matched"])
    assert (content["run_a"], content["run_b"], content["preset"]) == ("run", "moved", "default")
    for name in ("compare.png", "trajectories.png", "errors.png", "instances.png"):
        picture = cv2.imread(str(out / name))
        assert min(picture.shape[:2]) > 300
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20
    entities = {chunk.entity_path for chunk in rr.chunk.RrdReader(out / "compare.rrd").stream().to_chunks()}
    parts = {"a/mesh", "b/mesh", "a/trajectory", "b/trajectory", "a/matched", "b/matched", "pairs"}
    assert {f"/{part}" for part in parts} <= entities
    shown = []
    monkeypatch.setattr(rerun_viewer, "open_viewer", lambda *arguments: shown.append(arguments))
    assert call("view", out / "compare.rrd") == 0
    assert shown == [(out / "compare.rrd", False)]


def test_maps_of_different_places_are_warned_of_though_their_poses_agree(run, moved, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(run, other)
    mesh = read_mesh_ply(run / "mesh.ply")
    write_mesh_ply(other / "mesh.ply", replace(mesh, vertices=1.7 * mesh.vertices))
    assert call("compare", run, other, "-o", tmp_path / "out", "--json") == 0
    out, err = capsys.readouterr()
    assert "WARNING: A and B may be of different places" in err
    assert len(json.loads(out)["warnings"]) == 1
    assert compare_runs(run, moved, None, RULES).warnings == ()


# What cannot be compared


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("RUN", "EMPTY"), "is no run folder"),
        (("NOWHERE", "RUN"), "is no run folder"),
        (("RUN", "LATE"), "0 stamps in common"),
        (("RUN", "SHORT"), "2 stamps in common"),
        (("RUN", "UNPOSED"), "holds no pose"),
        (("RUN", "BROKEN"), "damaged"),
        (("RUN", "RUN", "--truth", "EMPTY"), "holds no ground truth"),
        (("RUN", "RUN", "--truth", "UNPOSED TRUTH"), "has no camera poses"),
        (("RUN", "RUN", "--preset", "mine"), "choose one of"),
        (("RUN", "RUN", "-o", "FILE"), "is not a folder"),
    ],
)
def test_what_cannot_be_compared_is_one_plain_line(room, run, tmp_path, capsys, arguments, message):
    places = {"RUN": run, **{name: tmp_path / name for name in ("EMPTY", "NOWHERE", "FILE", "UNPOSED TRUTH")}}
    places["EMPTY"].mkdir()
    places["FILE"].write_text("")
    shutil.copytree(room / "truth", places["UNPOSED TRUTH"] / "truth")
    places["LATE"] = copy_with(run, tmp_path / "late", lambda s, p, r: (s + 1000, p, r))
    places["SHORT"] = copy_with(run, tmp_path / "short", lambda s, p, r: (s[:2], p[:2], r[:2]))
    for name, file, content in (("UNPOSED", "trajectory.txt", "# none\n"), ("BROKEN", "instances.json", "{}")):
        places[name] = tmp_path / name
        shutil.copytree(run, places[name])
        (places[name] / file).write_text(content)
    capsys.readouterr()
    assert call("compare", *(places.get(argument, argument) for argument in arguments)) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (run / "compare").exists()


# Real data


@pytest.mark.full
def test_a_kitchen_under_given_and_under_estimated_poses_is_one_kitchen(real_data, tmp_path, capsys):
    """Its path is nearly flat: aligned by positions, F at 5 cm was 0.26 and hardly an instance in both maps."""
    which = ("--end", 200, "--stride", 5, "--poses", "both", "--no-timeline", "--device", "cpu")
    which += (
        "--set",
        "surface_segmentation.use=never",
    )  # what segments of two surfaces have in common is another matter
    assert call("run", real_data / "redkitchen", "-o", tmp_path / "both", *which, "--json") == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert result["surface"]["fscore_5cm"] > 0.97
    assert result["pose"]["rotation_rmse_deg"] < 2.5
    assert "nearly flat" in result["pose"]["degenerate"]
    assert len(result["instances"]["matched"]) > 5 * len(result["instances"]["missed"])
    assert result["frames"]["a"]["frames"] == result["frames"]["b"]["frames"] == 40
    off = np.linalg.inv(result["alignment"]["a_from_b_by_poses"]) @ result["alignment"]["a_from_b"]
    assert np.degrees(Rotation.from_matrix(off[:3, :3]).magnitude()) < 1
