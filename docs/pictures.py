"""The pictures of the documentation that need no browser: the demo's sheet, a map with its names, an answer, two runs
compared, a map with and without names, and what mistakes in a recording look like. `make pictures` writes them to
docs/*.png."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from PIL import Image

from app.pictures.captions import captioned_row
from app.pictures.map_picture import draw
from app.pictures.picture_file import write_picture
from app.pictures.scenes import map_scene
from app.pictures.view import Angle, Style, View
from data_tools.recordings.trajectories import read_trajectory, tum_line
from razer.arrays import Uint8Array
from razer.geometry import inverse
from razer.saved_map import load_map

HERE = Path(__file__).resolve().parent
WIDTH = {
    "demo.png": 1800,
    "apartment.png": 1400,
    "answer.png": 1100,
    "compare.png": 1540,
    "models.png": 1400,
    "mistakes.png": 1500,
}
COLORS = 256  # of a picture in the repository, a third of its size
STRIDE, ROOM_FRAMES = "3", "90"
ORACLE = ("--segmenter", "oracle", "--embedder", "oracle", "--set", "segmenter.options.stuff=true", "--no-timeline")
GEOMETRIC = ("--segmenter", "geometric", "--embedder", "appearance", "--no-timeline")
QUESTION = "something to sit on"
PANEL = (700, 620)  # width and height, pixels


def razer(*arguments: str | Path) -> None:
    """Run a verb; ends the program where that fails."""
    subprocess.run([sys.executable, "-m", "app", *map(str, arguments)], check=True)


def run_once(recording: Path, run: Path, *options: str) -> None:
    """Map a recording, unless the run is there already."""
    if not run.exists():
        razer("run", recording, "-o", run, *options)


def shrink(picture: Path) -> None:
    """Write a picture into docs/ as wide as its page needs it."""
    image = Image.open(picture).convert("RGB")
    width = min(WIDTH[picture.name], image.width)
    image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    target = HERE / picture.name
    image.quantize(COLORS, Image.Quantize.MAXCOVERAGE, kmeans=3).save(target, optimize=True)
    print(f"{target}: {image.width}x{image.height}, {target.stat().st_size / 1e6:.1f} MB")


def apartment(work: Path) -> list[Path]:
    """The map with its names, an answer, and two runs compared."""
    recording, given, estimated = work / "apartment", work / "given_poses", work / "estimated_poses"
    if not recording.exists():
        razer("synth", recording, "--scene", "apartment")
    for run, poses in ((given, "given"), (estimated, "slam")):
        run_once(recording, run, "--poses", poses, "--stride", STRIDE, *ORACLE)
    razer("view", given, "--picture", work / "apartment.png")
    razer("view", given, "--picture", work / "answer.png", "--query", QUESTION)
    razer("compare", given, estimated, "-o", work)
    return [work / "apartment.png", work / "answer.png", work / "compare.png"]


def room(work: Path) -> list[Path]:
    """A room without names and with them; and the same room under mistakes that recordings have."""
    recording, inverted = work / "room", work / "room_inverted"
    if not recording.exists():
        razer("synth", recording, "--frames", ROOM_FRAMES)
    if not inverted.exists():
        invert_poses(recording, inverted)
    run_once(recording, work / "room_geometric", *GEOMETRIC)
    run_once(recording, work / "room_named", *ORACLE)
    run_once(inverted, work / "room_world_to_camera", *ORACLE)
    run_once(recording, work / "room_depth_scale", "--depth-scale", "5000", *ORACLE)
    angle = draw(map_scene(load_map(work / "room_named"), "instance")).angle
    models = [("geometric: things without names", "room_geometric"), ("things by name", "room_named")]
    mistakes = [
        ("as it should be", "room_named"),
        ("poses world to camera", "room_world_to_camera"),
        ("depth scale 5000 for 1000", "room_depth_scale"),
    ]
    write_row(work / "models.png", [(text, panel(work / run, "instance", angle)) for text, run in models])
    write_row(work / "mistakes.png", [(text, panel(work / run, "color", angle)) for text, run in mistakes])
    return [work / "models.png", work / "mistakes.png"]


def invert_poses(recording: Path, inverted: Path) -> None:
    """A copy of a recording with poses that take the world to the camera."""
    shutil.copytree(recording, inverted)
    given = read_trajectory(recording / "trajectory.txt")
    poses = zip(given.stamps.tolist(), given.matrices(), strict=True)
    lines = [tum_line(stamp, inverse(pose)) for stamp, pose in poses]
    (inverted / "trajectory.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def panel(run: Path, style: Style, angle: Angle) -> Uint8Array:
    """The picture of a map; in its own colours without names."""
    scene = map_scene(load_map(run), style)
    return draw(replace(scene, names={}) if style == "color" else scene, View(angle, PANEL)).pixels


def write_row(target: Path, panels: Sequence[tuple[str, Uint8Array]]) -> None:
    """Pictures side by side as one file."""
    write_picture(target, captioned_row(panels))


def main() -> None:
    """Make the runs that are not in the folder yet, and the pictures of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path, help="a folder for recording and runs, taken up again where they are there")
    work: Path = parser.parse_args().work
    work.mkdir(parents=True, exist_ok=True)
    razer("demo", "-o", work / "demo")
    for picture in (work / "demo" / "demo.png", *apartment(work), *room(work)):
        shrink(picture)


if __name__ == "__main__":
    main()
