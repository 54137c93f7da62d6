"""`razer convert` from the outside: what it writes, what it says, how it refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.open_truth import open_truth
from data_tools.writers.own_folder import write_folder
from data_tools.writers.table import WRITERS
from tests.support.cli import razer
from tests.support.recordings import camera_json, colour, depth, write_image, write_seven_scenes
from tests.support.recordings import write_folder as write_plain_folder

LAYOUTS = {name: name if name != "own" else "folder" for name in WRITERS}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A synthetic room with its truth, in the project's own layout."""
    folder = tmp_path_factory.mktemp("made") / "room"
    room = SyntheticRoom(0, 4, 64, 48)
    write_folder(room, folder, truth=room.truth(0.1), lossless=True)
    return folder


@pytest.mark.parametrize("layout", WRITERS)
def test_a_recording_and_its_truth_reach_every_layout(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], layout: str
) -> None:
    out = tmp_path / "out"
    code, stdout, stderr = razer(capsys, "convert", recording, out, "--layout", layout, "--json", "--lossless")
    assert code == 0
    assert recognise(out) == LAYOUTS[layout]
    (line,) = stdout.splitlines()
    assert json.loads(line) == {
        "format": 1, "recording": "room", "out": str(out), "layout": layout, "frames": 4, "written": 4,
        "skipped": [], "truth": True,
    }  # fmt: skip
    assert "4/4 frames" in stderr
    before, after = open_sequence(recording), open_sequence(out)
    for i in range(4):
        np.testing.assert_allclose(after[i].pose, before[i].pose, atol=1e-6)
        np.testing.assert_array_equal(after[i].rgb, before[i].rgb)
        np.testing.assert_allclose(after[i].depth, before[i].depth, atol=6e-4)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    truth, carried = open_truth(recording), open_truth(out)
    np.testing.assert_array_equal(carried.vertices, truth.vertices)
    np.testing.assert_array_equal(carried.instances, truth.instances)
    if layout != "scenenn":  # which has the 40 classes of NYU alone
        assert carried.instance_classes == truth.instance_classes


def test_stride_and_max_frames_choose_frames(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = razer(capsys, "convert", recording, tmp_path / "a", "--stride", 2, "--max-frames", 1)
    assert code == 0
    assert out.startswith(
        f"{tmp_path / 'a'}: 1 of 1 frames with their ground truth, layout own\noutputs in {tmp_path / 'a'}:"
    )
    code, out, _ = razer(capsys, "convert", recording, tmp_path / "b", "--stride", 3, "--json")
    assert json.loads(out)["written"] == 2
    sequence, source = open_sequence(tmp_path / "b"), open_sequence(recording)
    assert [sequence[i].stamp for i in range(2)] == [source[i].stamp for i in (0, 3)]


def test_skipped_frames_are_counted_and_named_by_their_place_in_the_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_seven_scenes(tmp_path / "in", frames=9)
    (folder / "frame-000004.pose.txt").write_text("nan " * 16)
    (folder / "frame-000006.depth.png").unlink()
    code, out, _ = razer(capsys, "convert", folder, tmp_path / "out", "--stride", 2)
    assert code == 0
    assert out.splitlines()[:3] == [
        "skipped frame 4: in/frame-000004.pose.txt: the pose is not finite",
        "skipped frame 6: in/frame-000006.depth.png is missing",
        f"{tmp_path / 'out'}: 3 of 5 frames, layout own",
    ]
    sequence = open_sequence(tmp_path / "out")
    assert [sequence[i].pose[0, 3] for i in range(3)] == [0, 2, 8]
    code, out, _ = razer(capsys, "convert", folder, tmp_path / "again", "--stride", 2, "--json")
    assert [each["frame"] for each in json.loads(out)["skipped"]] == [4, 6]


def test_many_skipped_frames_are_not_all_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_seven_scenes(tmp_path / "in", frames=9)
    for i in range(1, 9):
        (folder / f"frame-{i:06d}.pose.txt").write_text("0 " * 16)
    code, out, _ = razer(capsys, "convert", folder, tmp_path / "out")
    told = out.partition("outputs in")[0]
    assert (code, len(told.splitlines())) == (0, 7)
    assert "skipped 3 more" in told


def test_a_recording_without_poses_and_with_a_declared_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_plain_folder(tmp_path / "in")
    options = ("--intrinsics", "10,11,3.5,2.5", "--depth-scale", 2000)
    code, _, _ = razer(capsys, "convert", folder, tmp_path / "out", *options)
    sequence = open_sequence(tmp_path / "out")
    assert (code, sequence.has_poses, sequence.intrinsics.fy) == (0, False, 11)
    assert sequence[0].depth[0, 0] == 1


def _no_usable_frame(tmp_path: Path) -> list[object]:
    folder = write_seven_scenes(tmp_path / "in", frames=2)
    for path in folder.glob("*.pose.txt"):
        path.write_text("1 0 0 -inf 0 1 0 0 0 0 1 0 0 0 0 1")
    return [folder, tmp_path / "out"]


def _existing(tmp_path: Path) -> list[object]:
    (tmp_path / "out").mkdir()
    return [write_seven_scenes(tmp_path / "in"), tmp_path / "out"]


def _no_camera(tmp_path: Path) -> list[object]:
    return [write_seven_scenes(tmp_path / "in", intrinsics=False), tmp_path / "out"]


def _unknown_file(tmp_path: Path) -> list[object]:
    (tmp_path / "a.txt").write_text("hello")
    return [tmp_path / "a.txt", tmp_path / "out"]


REFUSALS = {
    "no recording": (lambda tmp_path: [tmp_path / "nowhere", tmp_path / "out"], "does not exist"),
    "no usable frame": (_no_usable_frame, "none of 2 frames can be used, first frame 0: .*not finite"),
    "existing folder": (_existing, "out exists"),
    "no camera": (_no_camera, "--intrinsics fx,fy,cx,cy"),
    "a file of another kind": (_unknown_file, r"a\.txt"),
    "unknown layout": (
        lambda tmp_path: [write_seven_scenes(tmp_path / "in"), tmp_path / "out", "--layout", "kitti"],
        "unknown layout 'kitti': choose one of own",
    ),
    "stride of nothing": (
        lambda tmp_path: [write_seven_scenes(tmp_path / "in"), tmp_path / "out", "--stride", 0],
        "setting input.stride = 0",
    ),
}


@pytest.mark.parametrize("refusal", REFUSALS)
def test_what_cannot_be_converted_is_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], refusal: str
) -> None:
    prepare, message = REFUSALS[refusal]
    code, out, err = razer(capsys, "convert", *prepare(tmp_path))
    lines = [line for line in err.splitlines() if "frames, " not in line]
    assert (code, out) == (2, "")
    assert len(lines) == 1, err
    assert lines[0].startswith("razer: ")
    assert re.search(message, lines[0])
    assert {path.name for path in tmp_path.iterdir()} <= {"in", "a.txt", "out"}
    assert not (tmp_path / "out").exists() or not any((tmp_path / "out").iterdir())


def test_colour_and_depth_of_different_rate_are_written_as_pairs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "in"
    for i in range(8):
        write_image(folder / "color" / f"{i}.png", colour(i))
    for i in range(0, 8, 2):
        write_image(folder / "depth" / f"{i}.png", depth(1000 + i))
    (folder / "intrinsics.json").write_text(json.dumps(camera_json()))
    code, out, _ = razer(capsys, "convert", folder, tmp_path / "out", "--lossless", "--json")
    assert (code, json.loads(out)["written"]) == (0, 4)
    sequence = open_sequence(tmp_path / "out")
    assert [int(sequence[i].rgb[0, 0, 0]) for i in range(4)] == [0, 2, 4, 6]
