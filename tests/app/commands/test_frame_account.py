"""The account of frames: every verb says the same of a run, and what its trajectory says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.run_folder.mapped_run import read_run
from data_tools.recordings.sequence import FrameIteration
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.synthetic_scene import SyntheticScene
from data_tools.writers.own_folder import write_folder
from tests.support.cli import QUICK, razer

FORMAT_1 = Path(__file__).resolve().parents[2] / "fixtures" / "run_format_1"
KEYS = {"frames", "used", "skipped", "lost", "lost_intervals", "tracked", "asked"}
Account = dict[str, Any]


def account_in(content: dict[str, Any]) -> Account:
    assert set(content) >= KEYS
    return {key: content[key] for key in KEYS}


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    """What a command prints with --json."""
    capsys.readouterr()
    code, out, err = razer(capsys, *arguments, "--json")
    assert code == 0, err
    content: dict[str, Any] = json.loads(out.splitlines()[-1])
    return content


def accounts_of(capsys: pytest.CaptureFixture[str], run: Path, recording: Path) -> list[Account]:
    """What the run folder, `compare` and `eval` say of a run."""
    compared = printed(capsys, "compare", run, run, "-o", run.with_name("compared"))
    evaluated = printed(capsys, "eval", run, "--truth", recording)
    assert compared["pose"]["tracked_a"] == compared["pose"]["tracked_b"]
    told = [
        json.loads((run / "timings.json").read_text())["account"],
        compared["frames"]["a"],
        compared["frames"]["b"],
        evaluated["scenes"][run.name]["frames"],
    ]
    assert compared["pose"]["tracked_a"] == told[0]["tracked"]
    if evaluated["pose"] is not None:
        assert evaluated["pose"]["tracked"] == told[0]["tracked"]
    return told


def check(account: Account, poses: Path, asked: list[int]) -> None:
    """An account is consistent in itself, with the file of poses, and with the frames asked for."""
    assert account["asked"] == len(asked)
    assert account["frames"] == account["used"] + len(account["skipped"]) + account["lost"]
    assert account["tracked"] == account["used"] / len(asked)
    used = np.rint(30 * np.loadtxt(poses, ndmin=2)[:, 0]).astype(int).tolist()
    assert len(used) == account["used"]
    skipped = [one["frame"] for one in account["skipped"]]
    came = asked[: account["frames"]]
    lost = set(came) - set(used) - set(skipped)
    assert set(used) | set(skipped) <= set(came)
    assert len(lost) == account["lost"]
    within = {index for first, last in account["lost_intervals"] for index in came if first <= index <= last}
    assert within - set(skipped) == lost


class Torn(FrameIteration):
    """Frames of a room in another order, each 1/30 s apart; where the order says None the camera sees nothing."""

    def __init__(self, room: Any, order: list[int | None]) -> None:
        self._room, self._order = room, order
        self.name, self.intrinsics, self.has_poses, self.depth_scale = "torn", room.intrinsics, True, room.depth_scale

    def __len__(self) -> int:
        return len(self._order)

    def __getitem__(self, index: int) -> Any:
        place = self._order[index]
        frame = replace(self._room[place or 0], index=index, stamp=index / 30)
        if place is not None:
            return frame
        return replace(frame, rgb=np.zeros_like(frame.rgb), depth=np.full_like(frame.depth, 30.0))


def tear(recording: Path, *indices: int) -> None:
    for index in indices:
        (image,) = (recording / "color").glob(f"{index:06d}.*")
        image.write_bytes(b"")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sixteen frames with poses and truth, two of which cannot be read."""
    folder = tmp_path_factory.mktemp("accounts") / "room"
    room = SyntheticRoom(0, 16, 96, 72)
    write_folder(Torn(room, list(range(16))), folder, truth=room.truth(0.1))
    tear(folder, 5, 8)
    return folder


A_PART = ("--start", 3, "--end", 13, "--stride", 2, "--max-frames", 4)


@pytest.mark.parametrize(
    ("options", "asked"),
    [
        (A_PART, [3, 5, 7, 9]),
        pytest.param((), list(range(16)), marks=pytest.mark.full),
        pytest.param(("--stride", 2), list(range(0, 16, 2)), marks=pytest.mark.full),
    ],
)
def test_verbs_agree_on_a_run_with_given_poses(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[object, ...], asked: list[int]
) -> None:
    run = tmp_path / "run"
    told = printed(capsys, "run", room, "-o", run, *options, *QUICK, "--no-timeline")
    account = account_in(told)
    assert accounts_of(capsys, run, room) == [account] * 4
    check(account, run / "trajectory.txt", asked)
    assert [one["frame"] for one in account["skipped"]] == [index for index in (5, 8) if index in asked]
    assert (account["lost"], told["timings"]["frames"]) == (0, account["frames"])


@pytest.mark.full
def test_verbs_agree_on_a_run_whose_camera_was_lost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The camera goes blind after three frames and comes back elsewhere: in the end that place is the world, so that
    the first frames are lost after all, and most others come late."""
    recording, run = tmp_path / "torn", tmp_path / "run"
    room = SyntheticScene("room", 1, 100, 320, 240, sensor=SensorModel.kinect())
    write_folder(Torn(room, [*range(3), *[None] * 3, *range(60, 75)]), recording, truth=room.truth(0.1))
    tear(recording, 10)
    arguments = (recording, "-o", run, "--poses", "slam", "--max-frames", 20, *QUICK, "--no-timeline")
    told = printed(capsys, "run", *arguments)
    account = account_in(told)
    assert accounts_of(capsys, run, recording) == [account] * 4
    check(account, run / "trajectory.txt", list(range(20)))
    assert told["timings"]["frames"] == account["frames"] == 20
    assert told["timings"]["fps"] == pytest.approx(20 / told["timings"]["wall_s"], rel=0.01)
    assert account["lost"] >= 3
    assert account["used"] >= 10
    tracked = printed(capsys, "track", recording, "-o", tmp_path / "track.txt", "--max-frames", 20)
    assert account_in(tracked) == account
    assert np.loadtxt(tmp_path / "track.txt")[:, 0].tolist() == np.loadtxt(run / "trajectory.txt")[:, 0].tolist()


def test_a_run_that_kept_no_account_says_only_what_is_certain(tmp_path: Path) -> None:
    account = read_run(FORMAT_1).account
    assert account is not None
    assert (account.used, account.frames, account.lost, account.asked, account.tracked) == (10, 10, 0, None, None)


def timings(**more: object) -> str:
    return json.dumps({"format": 1, "frames": 14, **more})


FULL = {"frames": 14, "used": 12, "asked": 20, "skipped": [], "lost": 2, "lost_intervals": [[3, 4]]}


@pytest.mark.parametrize(
    ("content", "known"),
    [
        (timings(), {"frames": 14}),
        (timings(rebuilding={}), {}),  # may have counted frames twice that came late
        (timings(account=FULL), {"frames": 14, "asked": 20, "tracked": 0.5}),  # the trajectory was cut since
        (timings(account=FULL | {"used": 10, "lost": 4}), {"frames": 14, "asked": 20, "tracked": 0.5, "lost": 4}),
        (timings(account={"frames": 14}), {}),
        ("[]", {}),
        ("{", {}),
        (None, {}),
    ],
)
def test_of_a_folder_that_was_changed_nothing_false_is_said(
    tmp_path: Path, content: str | None, known: dict[str, Any]
) -> None:
    run = tmp_path / "run"
    run.mkdir()
    for file in FORMAT_1.iterdir():
        (run / file.name).write_bytes(file.read_bytes())
    (run / "timings.json").unlink()
    if content is not None:
        (run / "timings.json").write_text(content)
    account = read_run(run).account
    assert account is not None
    told = account.as_json()
    assert told["used"] == 10
    assert {key: told[key] for key in ("frames", "asked", "tracked", "lost")} == {
        "frames": None, "asked": None, "tracked": None, "lost": None,
    } | known  # fmt: skip
