"""What SCENES names: a folder of recordings, a dataset in a known layout, a list file, or a URI of one of them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from app.console.streams import print_notes
from app.object_store.attempts import persistently
from app.object_store.place import Place
from app.object_store.publishing import read_text
from data_tools.registry import recognise
from razer.errors import BadInput
from razer.files import read_lines

LISTED_AT_ONCE = 16  # folders of a store
RESERVED = ("batch_logs", "report.json", "evaluation.json")
_MAX_DEPTH = 3  # 7-Scenes: the scene, in it the sequence
_RECORDING_FILES = (".sens", ".bag", ".r3d")
_RECORDING_FOLDERS = ("color", "rgb", "depth", "results", "image")


@dataclass(frozen=True)
class Scene:
    """A recording and what its run folder is called; unlike all others of the batch."""

    name: str
    recording: Place


def scenes_of(text: str) -> list[Scene]:
    """The scenes that SCENES names, by name; raises BadInput where there are none, or two of one name."""
    place = Place.of(text)
    if place.is_remote:
        found = _listed(place, read_text(place)) if place.text.endswith(".txt") else _in_store(place)
    else:
        if not place.path.exists():
            raise BadInput(f"{text} does not exist: give a folder of recordings, a list file or a URI")
        is_list = place.path.is_file() and place.path.suffix not in _RECORDING_FILES
        found = _listed(place, "\n".join(read_lines(place.path))) if is_list else _in_folder(place.path)
    if not found:
        raise BadInput(f"{text} holds no recording in a known layout (razer inspect FOLDER says why not)")
    return _checked(found)


def _in_folder(folder: Path) -> list[Scene]:
    """A recording by itself, else those in the folders below."""
    if _is_recording(folder) and not _holds_several(folder):
        return [Scene(_stem(folder), Place(str(folder)))]
    notes: list[str] = []
    found = _below(folder, 1, notes)
    print_notes(notes)
    return [Scene("_".join((*path.relative_to(folder).parts[:-1], _stem(path))), Place(str(path))) for path in found]


def _stem(path: Path) -> str:
    """Of a folder the whole name, whatever dots are in it."""
    return path.stem if path.is_file() else path.name


def _holds_several(folder: Path) -> bool:
    """Whether a folder, which the file of a recording in it makes one, has others beside that."""
    inside = [path for path in folder.iterdir() if path.suffix in _RECORDING_FILES] if folder.is_dir() else []
    return len(inside) > 1 or (bool(inside) and len(_below(folder, _MAX_DEPTH, [])) > 1)


def _below(folder: Path, depth: int, notes: list[str]) -> list[Path]:
    """The recordings in a folder; notes what there can be none of, as it cannot be read."""
    found = []
    try:
        inside = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    except OSError as error:
        notes.append(f"{folder} cannot be read ({error.strerror}): left out")
        return []
    for path in inside:
        if not os.path.exists(path):
            notes.append(f"{path} leads nowhere: left out")
        elif _is_recording(path):
            found.append(path)
        elif path.is_dir() and depth < _MAX_DEPTH:
            found += _below(path, depth + 1, notes)
    return found


def _is_recording(path: Path) -> bool:
    if path.is_file():
        return path.suffix in _RECORDING_FILES
    try:
        recognise(path)
    except (BadInput, OSError):
        return False
    return True


def _in_store(place: Place) -> list[Scene]:
    """The same in a store, by names alone: a recording there is what has a folder of images, or is one file."""
    if place.name.endswith(_RECORDING_FILES):
        return [Scene(*_named(place))]
    inside = _listing(place)
    if _looks_like_recording(inside):
        return [Scene(*_named(place))]
    names = [name for name in inside if not name.startswith(".")]

    def is_recording(name: str) -> bool:
        return _looks_like_recording(_listing(place / name)) if inside[name] else name.endswith(_RECORDING_FILES)

    with ThreadPoolExecutor(LISTED_AT_ONCE) as pool:
        found = list(pool.map(is_recording, names))
    return [Scene(*_named(place / name)) for name, is_one in zip(names, found, strict=True) if is_one]


def _looks_like_recording(inside: Mapping[str, bool]) -> bool:
    """Whether a folder with these in it, see `_listing`, is one recording."""
    if inside.keys() & {*_RECORDING_FOLDERS} or any(name.endswith((".color.png", ".color.jpg")) for name in inside):
        return True
    return sum(name.endswith(_RECORDING_FILES) for name in inside) == 1 and not any(inside.values())


def _listing(place: Place) -> dict[str, bool]:
    """What is in a folder of a store, by name; whether it is a folder."""
    store, key = place.opened()

    def look() -> dict[str, bool]:
        store.invalidate_cache()
        try:
            found = {entry["name"].rstrip("/"): entry["type"] == "directory" for entry in store.ls(key, detail=True)}
        except FileNotFoundError:
            return {}
        # A folder may have a key of its own, which is listed as if it were in it.
        return {path.rpartition("/")[2]: found[path] for path in sorted(found.keys() - {key.rstrip("/")})}

    return persistently(look, f"{place} cannot be listed")


def _listed(place: Place, text: str | None) -> list[Scene]:
    """The scenes of a list: a path or URI a line, relative to the list; # begins a remark."""
    if text is None:
        raise BadInput(f"{place} does not exist")
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    parent = Place(place.text.rpartition("/")[0] or "/")
    return [Scene(*_named(_resolved(parent, line))) for line in lines if line]


def _resolved(parent: Place, line: str) -> Place:
    return Place.of(line) if line.startswith("/") or "://" in line else Place.of((parent / line).text)


def _named(place: Place) -> tuple[str, Place]:
    """What a recording is called: as its folder or file."""
    return (Path(place.name).stem if place.name.endswith(_RECORDING_FILES) else place.name), place


def _checked(scenes: list[Scene]) -> list[Scene]:
    counts = Counter(scene.name for scene in scenes)
    double = [name for name, count in counts.items() if count > 1]
    if double:
        raise BadInput(_said_of_double([scene for scene in scenes if scene.name == double[0]]))
    for scene in scenes:
        if scene.name in RESERVED or scene.name.startswith(".") or not scene.name:
            raise BadInput(f"a scene cannot be called '{scene.name}': the batch keeps that name for itself")
    return sorted(scenes, key=lambda scene: scene.name)


def _said_of_double(scenes: list[Scene]) -> str:
    """Of scenes with one name: one recording listed twice, or several that are called alike."""
    first = scenes[0]
    if (count := scenes.count(first)) > 1:
        return f"{first.recording} is listed {count} times: leave all but one out"
    return f"{len(scenes)} recordings are called {first.name}: rename all but one, as runs bear the name"
