"""What SCENES names: a folder of recordings, a dataset in a known layout, a list file, or a URI of one of them."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from app.console.streams import print_notes
from app.object_store.attempts import persistently
from app.object_store.place import Place
from app.object_store.publishing import read_text
from data_tools.registry import recognise
from razer.errors import BadInput
from razer.files import read_lines

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
        return [Scene(folder.stem if folder.is_file() else folder.name, Place(str(folder)))]
    notes: list[str] = []
    found = _below(folder, 1, notes)
    print_notes(notes)
    return [Scene("_".join(path.relative_to(folder).with_suffix("").parts), Place(str(path))) for path in found]


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
    names = _names(place)
    if _looks_like_recording(names):
        return [Scene(Path(place.name).stem, place)]
    return [
        Scene(Path(name).stem, place / name)
        for name in names
        if not name.startswith(".")
        and (name.endswith(_RECORDING_FILES) or ("." not in name and _looks_like_recording(_names(place / name))))
    ]


def _looks_like_recording(names: list[str]) -> bool:
    """Whether a folder with these names in it is one recording."""
    if {*names} & {*_RECORDING_FOLDERS} or any(name.endswith((".color.png", ".color.jpg")) for name in names):
        return True
    return sum(name.endswith(_RECORDING_FILES) for name in names) == 1 and all("." in name for name in names)


def _names(place: Place) -> list[str]:
    store, key = place.opened()

    def look() -> list[str]:
        store.invalidate_cache()
        try:
            return sorted({path.rstrip("/").rpartition("/")[2] for path in store.ls(key, detail=False)} - {place.name})
        except FileNotFoundError:
            return []

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
    """What a recording is called: as its folder or file; a whole URI has a host first, which is no name."""
    name = place.name if place.is_remote and not urlsplit(place.text).path.strip("/") else Path(place.name).name
    return (Path(name).stem if name.endswith(_RECORDING_FILES) else name), place


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
