"""The end of a verb: the files that it wrote, and what to do next."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from app.console.streams import progress_console, result_console

CONTENTS = {
    "mesh.ply": "the surface, coloured, with the instance of each vertex",
    "mesh.glb": "the same for viewers, a named node for each instance",
    "instances.json": "names, boxes, scores, relations",
    "map.npz": "what queries and edits need, with embeddings.npz",
    "trajectory.txt": "where the camera was: stamp tx ty tz qx qy qz qw",
    "given_trajectory.txt": "the poses that these were corrected from",
    "world.json": "where the origin of the map is in the world of the recording",
    "timeline.rrd": "the run as it went, for Rerun",
    "timings.json": "time of each stage, memory, frames that were left out",
    "config.toml": "all settings, for --config",
}
Words = tuple[object, ...]
_FEW = 3  # files of a kind that are named one by one


def print_outputs(folder: Path, contents: Mapping[str, str] = CONTENTS, console: Console | None = None) -> None:
    """What there is in a folder of the files that `contents` tells about, a line each."""
    console = console or result_console()
    there = [name for name in contents if (folder / name).exists()]
    if not there:
        return
    console.print(f"outputs in {folder}:", soft_wrap=True)
    width = max(map(len, there))
    for name in there:
        console.print(f"  {name:<{width}} {contents[name]}", soft_wrap=True)


def print_files(folder: Path) -> None:
    """What there is in a folder with a file for each frame: of folders and of files of a kind, how many they are."""
    console = result_console()
    console.print(f"outputs in {folder}:", soft_wrap=True)
    rows = _file_rows(folder)
    width = max((len(name) for name, _ in rows), default=0)
    for name, about in rows:
        console.print(f"  {name:<{width}} {about}".rstrip(), soft_wrap=True)


def _file_rows(folder: Path) -> list[tuple[str, str]]:
    """Name, or pattern of names, and how many files these are where it is not one."""
    kinds: Counter[str] = Counter()
    for path in folder.iterdir():
        kinds[re.sub(r"\d+", "*", path.name)] += 1
    rows: dict[str, str] = {}
    for path in sorted(folder.iterdir()):
        kind = re.sub(r"\d+", "*", path.name)
        if path.is_dir():
            rows[f"{path.name}/"] = f"{sum(1 for _ in path.iterdir())} files"
        elif kinds[kind] > _FEW:
            rows[kind] = f"{kinds[kind]} files"
        else:
            rows[path.name] = ""
    return list(rows.items())


def print_next(*commands: Words) -> None:
    """Calls of the program that make sense now, each given by its words after `razer`; notes, so on standard error."""
    console = progress_console()
    for place, words in enumerate(commands):
        console.print(f"{'next:' if place == 0 else '     '} {command_line(words)}", soft_wrap=True)


def command_line(words: Words) -> str:
    """A call of the program as a shell takes it, by its words after `razer`."""
    return shlex.join(["razer", *map(str, words)])
