"""The end of a verb: the files that it wrote, and what to do next."""

from __future__ import annotations

import shlex
from pathlib import Path

from rich.console import Console

CONTENTS = {
    "mesh.ply": "the surface, coloured, with the instance of each vertex",
    "mesh.glb": "the same for viewers, a named node for each instance",
    "instances.json": "names, boxes, scores, relations",
    "map.npz": "what queries and edits need, with embeddings.npz",
    "trajectory.txt": "where the camera was: stamp tx ty tz qx qy qz qw",
    "timeline.rrd": "the run as it went, for Rerun",
    "timings.json": "time of each stage, memory, frames that were left out",
    "config.toml": "all settings, for --config",
}


def print_outputs(folder: Path, console: Console) -> None:
    """What there is in a run folder, a line each."""
    console.print(f"outputs in {folder}:", soft_wrap=True)
    there = [name for name in CONTENTS if (folder / name).exists()]
    for name in there:
        console.print(f"  {name:<15} {CONTENTS[name]}", soft_wrap=True)


def print_next(console: Console, *commands: tuple[object, ...]) -> None:
    """Calls of the program that make sense now, each given by its words after `razer`."""
    for place, words in enumerate(commands):
        line = shlex.join(["razer", *map(str, words)])
        console.print(f"{'next:' if place == 0 else '     '} {line}", soft_wrap=True)
