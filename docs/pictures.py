"""The pictures of the documentation that need no browser: the demo's sheet, a map with its names, two runs compared.
`make pictures` writes docs/demo.png, docs/apartment.png and docs/compare.png."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from PIL import Image

HERE = Path(__file__).resolve().parent
WIDTH = {"demo.png": 1800, "apartment.png": 1400, "compare.png": 1540}
COLORS = 256  # of a picture in the repository, a third of its size
STRIDE = "3"
ORACLE = ("--segmenter", "oracle", "--embedder", "oracle", "--set", "segmenter.options.stuff=true", "--no-timeline")


def razer(*arguments: str | Path) -> None:
    """Run a verb; ends the program where that fails."""
    subprocess.run([sys.executable, "-m", "app.cli", *map(str, arguments)], check=True)


def shrink(picture: Path) -> None:
    """Write a picture into docs/ as wide as its page needs it."""
    image = Image.open(picture).convert("RGB")
    width = min(WIDTH[picture.name], image.width)
    image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    target = HERE / picture.name
    image.quantize(COLORS, Image.Quantize.MAXCOVERAGE, kmeans=3).save(target, optimize=True)
    print(f"{target}: {image.width}x{image.height}, {target.stat().st_size / 1e6:.1f} MB")


def main() -> None:
    """Make the runs that are not in the folder yet, and the pictures of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path, help="a folder for recording and runs, taken up again where they are there")
    work: Path = parser.parse_args().work
    work.mkdir(parents=True, exist_ok=True)
    recording, given, estimated = work / "apartment", work / "given_poses", work / "estimated_poses"
    if not recording.exists():
        razer("synth", recording, "--scene", "apartment")
    for run, poses in ((given, "given"), (estimated, "slam")):
        if not run.exists():
            razer("run", recording, "-o", run, "--poses", poses, "--stride", STRIDE, *ORACLE)
    razer("demo", "-o", work / "demo")
    razer("view", given, "--picture", work / "apartment.png")
    razer("compare", given, estimated, "-o", work)
    for picture in (work / "demo" / "demo.png", work / "apartment.png", work / "compare.png"):
        shrink(picture)


if __name__ == "__main__":
    main()
