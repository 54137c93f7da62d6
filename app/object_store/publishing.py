"""Publishing without a rename: files go to temporary keys, from there to their own, and a manifest comes last."""

from __future__ import annotations

import json
import secrets
from pathlib import Path
from typing import Any

from app.object_store.attempts import persistently
from app.object_store.place import Place
from razer import files
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content

MANIFEST = "published.json"
UNPUBLISHED = ".unpublished"
_FORMAT = 1


def publish(folder: Path, place: Place) -> None:
    """Put a folder at a place of a store: whoever finds the manifest there finds all files, whole.

    Object stores write one key at once, and know no rename of many. So nothing appears under the final keys before all
    of it is in the store, and what does counts by the manifest, the last key that is written. Raises BadInput.
    """
    paths = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}
    parent = Place(place.text.rpartition("/")[0])
    hidden = parent / UNPUBLISHED / f"{place.name}-{secrets.token_hex(4)}"
    try:
        _upload(paths, hidden)
        _copy([*paths], hidden, place)
        manifest = {"format": _FORMAT, "files": {name: path.stat().st_size for name, path in paths.items()}}
        write_text(place / MANIFEST, json.dumps(manifest, indent=1) + "\n")
    finally:
        _remove(hidden)


def is_published(place: Place) -> bool:
    """Whether a folder is at a place of a store, whole; raises BadInput where the store does not answer."""
    return read_text(place / MANIFEST) is not None


def write_text(place: Place, text: str) -> None:
    """Put a text at a place, in one go; raises BadInput."""
    if not place.is_remote:
        replace_content(place.path, text)
        return
    store, key = place.opened()
    persistently(lambda: store.pipe_file(key, text.encode()), f"{place} cannot be written")


def read_text(place: Place) -> str | None:
    """The text at a place, None where there is none; raises BadInput."""
    if not place.is_remote:
        return files.read_text(place.path, max_bytes=files.MAX_BYTES) if place.path.is_file() else None
    store, key = place.opened()

    def read() -> bytes | None:
        store.invalidate_cache()
        try:
            return bytes(store.cat_file(key))
        except FileNotFoundError:
            return None

    content = persistently(read, f"{place} cannot be read")
    try:
        return None if content is None else content.decode()
    except UnicodeDecodeError as error:
        raise BadInput(f"{place} cannot be read: it is no UTF-8 text") from error


def _upload(files: dict[str, Path], hidden: Place) -> None:
    store, key = hidden.opened()
    arrived: set[str] = set()

    def put_missing() -> None:
        for name in sorted(set(files) - arrived):
            store.put_file(str(files[name]), f"{key}/{name}")
            _require_size(store, f"{key}/{name}", files[name].stat().st_size)
            arrived.add(name)

    persistently(put_missing, f"{hidden} cannot be written")


def _copy(names: list[str], hidden: Place, place: Place) -> None:
    store, source = hidden.opened()
    _, target = place.opened()
    left = sorted(names)

    def copy_left() -> None:
        while left:
            store.cp_file(f"{source}/{left[-1]}", f"{target}/{left[-1]}")
            left.pop()

    persistently(copy_left, f"{place} cannot be written")


def _require_size(store: Any, key: str, size: int) -> None:
    store.invalidate_cache()
    if (there := store.info(key)["size"]) != size:
        raise OSError(f"{there} of {size} bytes arrived")


def _remove(hidden: Place) -> None:
    """Leave no temporary keys; those that cannot be removed do no harm."""
    store, key = hidden.opened()

    def remove() -> None:
        store.invalidate_cache()
        if store.exists(key):
            store.rm(key, recursive=True)

    try:
        persistently(remove, f"{hidden} cannot be removed")
    except BadInput:
        return
