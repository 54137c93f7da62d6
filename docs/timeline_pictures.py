"""The pictures of docs/timeline.md: tabs of Rerun's page in a browser, on simulated recordings that anyone can make.
`make timeline-pictures` writes them to docs/timeline_*.png."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from data_tools.recordings.trajectories import read_trajectory, tum_line
from docs.pictures import COLORS, HERE, razer, run_once
from razer.arrays import Uint8Array
from tests.support.browser import chromium
from tests.support.timeline_page import OF_ONE_RUN, OF_TWO_RUNS, opened, served

FRAMES = "120"
BLIND = slice(50, 63)  # frames in which a hand covers the camera
DRIFT_M = 0.006  # a frame, of the poses that come with a recording
ORACLE = ("--segmenter", "oracle", "--embedder", "oracle", "--set", "segmenter.options.stuff=true")
SPLITTING = (*ORACLE, "--set", "segmenter.options.split=0.3", "--set", "segmenter.options.split_frames=20")
WIDTH = 1100
MENU_PX = 38  # of the viewer, at the top


def cover_camera(recording: Path, covered: Path) -> None:
    """A copy of a recording in which some frames are black."""
    shutil.copytree(recording, covered)
    for folder in ("color", "depth"):
        for path in sorted((covered / folder).iterdir())[BLIND]:
            image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            assert image is not None
            cv2.imwrite(str(path), np.zeros_like(image))


def let_poses_drift(recording: Path, drifting: Path) -> None:
    """A copy of a recording whose given positions stray farther and farther."""
    shutil.copytree(recording, drifting)
    given = read_trajectory(recording / "trajectory.txt")
    poses = given.matrices().copy()
    poses[:, :3, 3] += np.cumsum(np.random.default_rng(3).normal(0, DRIFT_M, (len(poses), 3)), axis=0)
    lines = [tum_line(stamp, pose) for stamp, pose in zip(given.stamps.tolist(), poses, strict=True)]
    (drifting / "trajectory.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def make_runs(work: Path) -> dict[str, tuple[Path, str]]:
    """The run and the tab of each picture; what is in the folder already is taken as it is."""
    room = work / "room"
    if not room.exists():
        razer("synth", room, "--frames", FRAMES)
    for name, change in (("covered", cover_camera), ("drifting", let_poses_drift)):
        if not (work / name).exists():
            change(room, work / name)
    run_once(work / "covered", work / "lost_run", "--poses", "slam", *ORACLE)
    run_once(room, work / "split_run", "--poses", "given", *SPLITTING)
    run_once(work / "drifting", work / "both_runs", "--poses", "both", *ORACLE)
    return {
        "overview": (work / "lost_run", "Overview"),
        "objects": (work / "split_run", "Objects"),
        "poses": (work / "lost_run", "Poses"),
        "both": (work / "both_runs", "Poses"),
    }


def shoot(run: Path, tab: str) -> Uint8Array:
    """The page (H, W, 3), BGR, with a tab open."""
    panels = (OF_TWO_RUNS if run.name == "both_runs" else OF_ONE_RUN)[tab]
    with chromium() as browser, served(run) as address, opened(browser, address) as page:
        page.open_tab("Overview", {})
        return page.open_tab(tab, panels)


def save(picture: Uint8Array, target: Path) -> None:
    """Write a page without the viewer's menu, as wide as the documentation needs it."""
    image = Image.fromarray(cv2.cvtColor(picture[MENU_PX:], cv2.COLOR_BGR2RGB))
    image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    image.quantize(COLORS, Image.Quantize.MAXCOVERAGE, kmeans=3).save(target, optimize=True)
    print(f"{target}: {image.width}x{image.height}, {target.stat().st_size / 1e6:.2f} MB")


def main() -> None:
    """Make the runs that are not in the folder yet, and the pictures of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path, help="a folder for recordings and runs, taken up again where they are there")
    parser.add_argument("-o", "--out", type=Path, default=HERE)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    for name, (run, tab) in make_runs(arguments.work).items():
        save(shoot(run, tab), arguments.out / f"timeline_{name}.png")


if __name__ == "__main__":
    main()
