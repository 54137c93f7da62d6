"""The command line as a user has it, called in this process, and a recording to call it with."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.cli import main
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording

N_FRAMES = 12
RUN_FILES = {
    "config.toml", "trajectory.txt", "mesh.ply", "mesh.glb", "instances.json", "embeddings.npz", "map.npz",
    "timings.json", "timeline.rrd", "rgbd_calibration.json", "camera.json",
}  # fmt: skip
QUICK = ("--set", "voxels.voxel_size_m=0.05", "--device", "cpu")


def call(*arguments: object) -> int:
    """Run a command in this process; returns its exit code."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    return int(stopped.value.code or 0)


def razer(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    """Run a command in this process; returns exit code, standard output, standard error."""
    code = call(*arguments)
    out, err = capsys.readouterr()
    return code, out, err


def environment() -> dict[str, str]:
    """That of a process of the program, wherever it works."""
    return {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2]), "RAY_USAGE_STATS_ENABLED": "0"}


def write_small_room(folder: Path, *, poses: bool = True, intrinsics: bool = True, n_frames: int = N_FRAMES) -> Path:
    """A small synthetic room in the project's own folder format, written independently of the project's writer."""
    room = SyntheticRoom(n_frames=n_frames, width=160, height=120)
    for name in ("color", "depth"):
        (folder / name).mkdir(parents=True)
    camera = room.intrinsics
    if intrinsics:
        numbers = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
        (folder / "intrinsics.json").write_text(json.dumps(numbers | {"depth_scale": 1000.0}))
    lines = []
    for index in range(n_frames):
        frame = room[index]
        cv2.imwrite(str(folder / f"color/{index:06d}.png"), frame.rgb[..., ::-1])
        cv2.imwrite(str(folder / f"depth/{index:06d}.png"), np.rint(frame.depth * 1000).astype(np.uint16))
        lines.append(tum_line(index / 30, frame.pose))
    if poses:
        (folder / "trajectory.txt").write_text("\n".join(lines) + "\n")
    return folder


def tum_line(stamp: float, pose: np.ndarray) -> str:
    rotation, w = pose[:3, :3], np.sqrt(max(1e-12, 1 + np.trace(pose[:3, :3]))) / 2
    x, y, z = (rotation[i, j] - rotation[j, i] for i, j in ((2, 1), (0, 2), (1, 0)))
    values = (*pose[:3, 3], *(np.array([x, y, z]) / (4 * w)), w)
    return f"{stamp:.6f} " + " ".join(f"{value:.9f}" for value in values)


def listing(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file in a folder and below, by its path in there."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def instances_of(run: Path) -> list[dict[str, Any]]:
    """The entries of a run's instances.json."""
    entries: list[dict[str, Any]] = json.loads((run / "instances.json").read_text())["instances"]
    return entries


ROOM_FRAMES, ROOM_SIZE = 24, (160, 120)  # of the room that several verbs are tried on


def map_oracle_room(place: Path, n_frames: int, size: tuple[int, int], embedder: str = "oracle") -> tuple[Path, Path]:
    """A small room with its truth, mapped with the simulator's masks: (run, recording), both in `place`."""
    room = SyntheticRoom(0, n_frames, *size)
    write_recording(room, place / "recording", truth=room.truth(0.05), lossless=True)
    models = ("--segmenter", "oracle", "--embedder", embedder)
    assert call("run", place / "recording", "-o", place / "run", *models, *QUICK, "--no-timeline") == 0
    return place / "run", place / "recording"
