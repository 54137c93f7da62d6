"""Checkpoint of a run: which states belong together, and what the run was."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from app.stored_state.saved_state import SavedState, tidy
from app.stored_state.written_log import WrittenLog
from razer.errors import BadInput
from razer.files import MALFORMED, MissingFile, read_json

FOLDER = "checkpoint"
FILE = "checkpoint.json"
FORMAT = 5


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run after `n_frames` of the `planned` frames: those of its two processes, which are of one moment.
    `first_frame`: hash of the recording's first frame; `vocabulary`: what the instances are to be named by; `timeline`:
    what was written of it, None where there is none."""

    n_frames: int
    planned: int
    map: SavedState
    poses: SavedState
    first_frame: str
    vocabulary: str | None = None
    timeline: WrittenLog | None = None

    def write(self, folder: Path) -> None:
        """Make it the one that the folder holds; whatever happens, it holds this one or the one before."""
        content = json.dumps({"format": FORMAT, **asdict(self)}).encode()
        part = folder / f".{FILE}.part"
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(folder / FILE)
        _sync_folder(folder)
        for state in (self.map, self.poses):
            tidy(folder, state)


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint in a folder, None where there is none; raises BadInput for one that cannot be used."""
    path = folder / FILE
    try:
        content = read_json(path)
    except MissingFile:
        return None
    except BadInput as error:
        raise BadInput(f"{error}; the checkpoint cannot be used") from None
    try:
        if content.pop("format") != FORMAT:
            raise BadInput(f"{path} is of another version of this program: the run cannot be resumed with this one")
        timeline = content["timeline"]
        return Checkpoint(
            n_frames=int(content["n_frames"]),
            planned=int(content["planned"]),
            map=_saved_state("map", content["map"]),
            poses=_saved_state("poses", content["poses"]),
            first_frame=str(content["first_frame"]),
            vocabulary=content["vocabulary"],
            timeline=None if timeline is None else _written_log(**timeline),
        )
    except BadInput:
        raise
    except MALFORMED as error:
        raise BadInput(f"{path} is damaged: the run cannot be resumed") from error


def _saved_state(name: str, content: Mapping[str, Any]) -> SavedState:
    return SavedState(name, int(content["number"]), tuple(int(pack) for pack in content["packs"]))


def _written_log(name: str, sizes: Iterable[tuple[str, int]]) -> WrittenLog:
    listed = tuple((str(part), int(size)) for part, size in sizes)
    if not all(re.fullmatch(r"timeline[.\d]*\.rrd", part) for part, _ in listed):
        raise ValueError("a part of the timeline that is none")
    return WrittenLog(str(name), listed)


def _sync_folder(folder: Path) -> None:
    """Make sure that names are on the disk as well."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
