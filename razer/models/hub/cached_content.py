"""Content of cached models, held against its published checksums before anything opens it.

The cache keeps a file under the checksum that the hub names for it, and a link to that where a model's files are looked
for. So a file that was damaged or replaced after its download is told from its own name, or from the catalogue.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

from razer.errors import BadInput
from razer.files import plain_os_errors
from razer.models.hub.catalogue import CatalogueEntry
from razer.models.hub.checksum import checksum, checksum_kind


@dataclass(frozen=True)
class Damage:
    """A file whose content is not what was published: its actual and its published checksum, of that kind."""

    file: Path
    kind: str
    actual: str
    published: str


def require_published(place: Path, entry: CatalogueEntry | None = None) -> None:
    """Raise BadInput for the first damaged file of a model, with the way out. Args as in `damages`."""
    for damage in damages(place, entry):
        command = entry.pull_command if entry else f"hf download {_repo(damage.file)} --force-download"
        raise BadInput(
            f"{damage.file} is damaged or was replaced: {damage.kind} {damage.actual}, expected {damage.published}; "
            f"run '{command}' to fetch it anew"
        )


def damages(place: Path, entry: CatalogueEntry | None = None) -> Iterator[Damage]:
    """What is damaged of a model.

    Args:
        place: its file or folder; files without a published checksum, such as a user's own, count as whole.
        entry: its entry of the catalogue: only files named there are looked at, and its checksums come first.

    Raises:
        BadInput: where a file cannot be read.
    """
    for file, name in _files(place, entry):
        published = (entry.sha256.get(name) if entry else None) or _name_in_cache(file)
        if kind := checksum_kind(published):
            with plain_os_errors(file):
                status = file.stat()
                actual = _checksum(file, kind, status.st_size, status.st_mtime_ns, status.st_ino)
            if actual != published:
                yield Damage(file, kind, actual, published)


def discard(damage: Damage) -> None:
    """Take a damaged file out of the cache, so that the next download fetches it. Content that is what its own name in
    the cache says stays: it is whole, of another version, and other programs may use it."""
    if damage.published == _name_in_cache(damage.file):
        damage.file.resolve().unlink()
    damage.file.unlink()


def _files(place: Path, entry: CatalogueEntry | None) -> Iterator[tuple[Path, str]]:
    """The files to look at, each with its name in the repository."""
    if place.is_file():
        yield place, entry.files[0] if entry else place.name
        return
    for file in sorted(place.rglob("*")):
        name = file.relative_to(place).as_posix()
        if file.is_file() and (entry is None or any(fnmatch(name, pattern) for pattern in entry.files)):
            yield file, name


def _name_in_cache(file: Path) -> str:
    """What the cache calls the content that a file of a snapshot links to; '' for other files."""
    target = file.readlink() if file.is_symlink() else Path()
    return target.name if target.parent.name == "blobs" else ""


def _repo(file: Path) -> str:
    """The repository, ORG/NAME, that a file of the cache comes from."""
    folders = [folder.name.split("--") for folder in file.absolute().parents if folder.name.startswith("models--")]
    return "/".join(folders[0][1:]) if folders else file.parent.name


@cache
def _checksum(file: Path, kind: str, n_bytes: int, mtime_ns: int, inode: int) -> str:
    """The checksum of a file that did not change since: several parts of a program ask for the same model."""
    return checksum(file, kind)
