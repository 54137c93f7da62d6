"""Staging: a recording is fetched once per machine, whoever on it asks for it."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path, PurePosixPath

from app.object_store.attempts import persistently
from app.object_store.place import Place
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content

STAGING = "RAZER_STAGING"  # in the environment: where to, else the temporary folder
_WHOLE = ".whole"
_AT_ONCE = 64


def staging_folder(kind: str, place: Place) -> Path:
    """Where this machine keeps what belongs to a place in a store."""
    parent = os.environ.get(STAGING) or os.path.join(tempfile.gettempdir(), f"razer-staging-{os.getuid()}")
    folder = Path(parent) / kind / sha256(place.text.encode()).hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def staged(place: Place) -> Path:
    """The folder, or file, on this machine with the content of the place; its own path, where that is here. It is
    fetched once: others who ask meanwhile wait. Raises BadInput."""
    if not place.is_remote:
        return place.path
    folder = staging_folder("inputs", place)
    target = folder / place.name
    with _locked(folder):
        if not (folder / _WHOLE).exists():
            _fetch(place, target)
            replace_content(folder / _WHOLE, place.text + "\n")
    return target


def forget(place: Place) -> None:
    """Remove what was staged of a place, so that a thousand of them need no room for all."""
    if place.is_remote:
        shutil.rmtree(staging_folder("inputs", place), ignore_errors=True)


def sizes(place: Place) -> dict[str, int]:
    """Bytes of each file of a place by its path in there; "" is that of a single file. Raises BadInput."""
    if not place.is_remote:
        root = place.path
        files = [root] if root.is_file() else [path for path in root.rglob("*") if path.is_file()]
        return {"" if path == root else path.relative_to(root).as_posix(): path.stat().st_size for path in files}
    store, key = place.opened()

    def look() -> dict[str, int]:
        store.invalidate_cache()
        found = store.find(key, detail=True)
        return {path[len(key) :].lstrip("/"): int(info["size"] or 0) for path, info in found.items()}

    return persistently(look, f"{place} cannot be listed")


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    with (folder / ".lock").open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _fetch(place: Place, target: Path) -> None:
    """Fetch what is not there yet: a fetch that was cut off goes on."""
    store, key = place.opened()
    wanted = sizes(place)
    if not wanted:
        raise BadInput(f"{place} does not exist, or is empty")
    paths = {name: target / _safe(place, name) if name else target for name in wanted}
    for path in {path.parent for path in paths.values()}:
        path.mkdir(parents=True, exist_ok=True)

    def get_missing() -> None:
        missing = [name for name, path in paths.items() if not path.is_file() or path.stat().st_size != wanted[name]]
        for first in range(0, len(missing), _AT_ONCE):
            some = missing[first : first + _AT_ONCE]
            store.get([f"{key}/{name}" if name else key for name in some], [str(paths[name]) for name in some])
        if short := [name for name in missing if paths[name].stat().st_size != wanted[name]]:
            raise OSError(f"{short[0] or place.name} came cut off")

    persistently(get_missing, f"{place} cannot be fetched")


def _safe(place: Place, name: str) -> PurePosixPath:
    """A path in a store as one below a folder; raises BadInput for one that would lead out of it."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts:
        raise BadInput(f"{place} has a file that leads out of it: {name}")
    return path
