"""Where the frame of a map lies in the world of its recording, for coordinates such as UTM's."""

from __future__ import annotations

import json
from pathlib import Path

from app.run_folder.run_folder import WORLD, RunFolder
from data_tools.recordings.local_origin import HERE, Origin
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content

FORMAT = 1


def save_world(folder: RunFolder, origin: Origin) -> None:
    """Write world.json, where the map does not lie in the frame of its recording."""
    if origin != HERE:
        content = {"format": FORMAT, "world_from_map": list(origin)}
        folder.write(WORLD, lambda path: replace_content(path, json.dumps(content) + "\n"))


def map_origin(run: Path) -> Origin:
    """What is added to the coordinates of a run's map and trajectory to have those of its recording, metres; HERE where
    the folder says nothing of it. Raises BadInput."""
    path = run / WORLD
    if not path.is_file():
        return HERE
    try:
        x, y, z = (float(value) for value in json.loads(path.read_text(encoding="utf-8"))["world_from_map"])
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInput(f'{path} must read {{"format": 1, "world_from_map": [x, y, z]}}, metres') from None
    return x, y, z
