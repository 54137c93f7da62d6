"""`razer run` on what cannot be used: exit code 2, one plain line, nothing left."""

from __future__ import annotations

import re

import cv2
import numpy as np
import pytest

from tests.support.cli import QUICK, listing, razer, write_small_room


def broken_recording(folder, n_broken):
    write_small_room(folder, n_frames=6)
    for index in range(n_broken):
        (folder / f"depth/{index:06d}.png").write_bytes(b"")
    return folder


def recording_with_bad_poses(folder):
    write_small_room(folder, n_frames=6)
    lines = [f"{index / 30:.6f} 0 0 0 0 0 0 0" for index in range(6)]
    (folder / "trajectory.txt").write_text("\n".join(lines))


INPUTS = {
    "good": write_small_room,
    "missing": lambda folder: folder,
    "empty": lambda folder: folder.mkdir(),
    "no poses": lambda folder: write_small_room(folder, poses=False, n_frames=3),
    "no intrinsics": lambda folder: write_small_room(folder, intrinsics=False, n_frames=3),
    "all broken": lambda folder: broken_recording(folder, 6),
    "bad poses": recording_with_bad_poses,
    "most broken": lambda folder: broken_recording(folder, 4),
}


@pytest.mark.parametrize(
    ("folder", "options", "message"),
    [
        ("missing", (), "in"),
        ("empty", (), "empty"),
        ("no poses", ("--poses", "given"), "no camera poses"),
        ("no poses", ("--poses", "given"), "trajectory.txt"),
        ("no poses", ("--poses", "refine"), "no camera poses"),
        ("good", ("--poses", "no-such.txt"), "no-such.txt: there is no such file, and it is none of given, slam"),
        ("good", ("--poses-from", "no-such.txt"), "no-such.txt cannot be read: No such file"),
        ("good", ("--poses", "pyproject.toml"), "pyproject.toml is no file of poses that is known"),
        ("good", ("--poses", "a.txt", "--poses-from", "b.txt"), "both name a file: leave one out"),
        ("no intrinsics", (), "intrinsics"),
        ("all broken", (), "holds no usable frame"),
        ("bad poses", (), "4 of 6 frames cannot be used, first frame 0: trajectory.txt"),
        ("bad poses", ("--max-bad", "1"), "6 of 6 frames cannot be used, first frame 0: trajectory.txt"),
        ("most broken", (), "4 of 6 frames cannot be used, first frame 0: .*000000.png"),
        (
            "good",
            ("--set", "voxels.voxelsize=0.1"),
            "unknown setting voxels.voxelsize; did you mean voxels.voxel_size_m",
        ),
        ("good", ("--set", "voxels.voxel_size_m=9"), "voxels.voxel_size_m = 9"),
        ("good", ("--config", "no-such.toml"), "no-such.toml"),
        ("good", ("--reader", "holograms"), "unknown reader 'holograms'"),
        ("good", ("--segmenter", "psychic"), "unknown segmenter 'psychic'"),
        (
            "good",
            ("--segmenter", "geometric", "--set", "segmenter.options.nonsense=1"),
            "segmenter 'geometric' does not take",
        ),
        ("good", ("--intrinsics", "1,2"), "intrinsics"),
        ("good", ("--stride", "0"), "input.stride = 0"),
        ("good", ("--start", "5", "--end", "3"), "input.end = 3: should be greater than input.start, 5"),
        ("good", ("--start", "12"), r"has frames 0 to 11: --start 12 lies past its end"),
    ],
)
def test_unusable_input_is_one_plain_line(capsys, tmp_path, folder, options, message):
    INPUTS[folder](tmp_path / "in")
    before = listing(tmp_path)
    code, out, err = razer(capsys, "run", tmp_path / "in", "-o", tmp_path / "deep" / "run", *QUICK, *options)
    assert (code, out) == (2, "")
    lines = [line for line in err.splitlines() if line.startswith("razer: ")]
    assert len(lines) == 1
    assert lines[0] == err.splitlines()[-1]
    assert "Traceback" not in err
    assert re.search(message, lines[0]), lines[0]
    assert listing(tmp_path) == before


def test_masks_of_other_frames_end_the_run_before_it_begins(capsys, tmp_path):
    write_small_room(tmp_path / "in", n_frames=3)
    masks = tmp_path / "masks"
    masks.mkdir()
    ids = np.zeros((120, 160), np.uint8)
    ids[40:80, 50:100] = 1
    run = ("run", tmp_path / "in", "-o", tmp_path / "out", *QUICK, "--no-timeline", "--segmenter", "masks")
    run += ("--set", f"segmenter.options.folder={masks}")
    for name in ("frame-000001.png", "000100.png"):
        for path in masks.iterdir():
            path.unlink()
        cv2.imwrite(str(masks / name), ids)
        code, out, err = razer(capsys, *run)
        assert (code, out) == (2, "")
        assert err.splitlines()[-1].startswith("razer: ")
        for part in (str(masks), name, "000007.png"):
            assert part in err.splitlines()[-1]
        assert not (tmp_path / "out").exists()
    cv2.imwrite(str(masks / "000001.png"), ids)
    code, _, err = razer(capsys, *run)
    assert code == 0
    assert "masks for 1 of 3 frames" in err
