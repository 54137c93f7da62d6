"""Resumable download of models from the Hugging Face Hub into its cache.

The hub's library discards partial downloads. So each file is downloaded here, under the name that the library itself
gives to unfinished ones, is checked, and only then handed to the library, which links it.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from filelock import FileLock
from huggingface_hub import HfApi, HfFileMetadata, get_hf_file_metadata, hf_hub_download, hf_hub_url
from huggingface_hub.file_download import http_get, repo_folder_name
from huggingface_hub.hf_api import RepoFile
from huggingface_hub.utils import build_hf_headers  # type: ignore[attr-defined]

from razer.errors import BadInput
from razer.models.hub.cache import cache_folder, cached_model
from razer.models.hub.cached_content import damages, discard
from razer.models.hub.catalogue import CatalogueEntry
from razer.models.hub.checksum import checksum, checksum_kind
from razer.models.hub.download_errors import as_bad_input


@dataclass(frozen=True)
class RemoteFile:
    """One file at the hub: `published` is its checksum there (see checksum_kind), `n_bytes` its size."""

    name: str
    published: str
    n_bytes: int


def fetch(entry: CatalogueEntry, report: Callable[[str], None]) -> Path:
    """Fetch what the cache lacks of a model or holds damaged, and return what `model_file` returns for its name.

    report is called with one line for each file. Raises BadInput where the hub, the network, the disk or the content of
    a file stands in the way; a partial download is kept, and the next call resumes it.
    """
    if (present := whole_model(entry, report)) is not None:
        return present
    with as_bad_input(entry):
        for file in sorted(remote_files(entry), key=lambda file: file.n_bytes):
            _fetch_file(entry, file, report)
    path = cached_model(entry)
    if path is None:
        raise BadInput(f"{entry.repo} changed while it was fetched: run the command again")
    return path


def whole_model(entry: CatalogueEntry, report: Callable[[str], None]) -> Path | None:
    """`cached_model` where its content is what was published; None, and damaged files are discarded, where it is not.
    report is called with one line for each."""
    present = cached_model(entry)
    damaged = [] if present is None else list(damages(present, entry))
    for damage in damaged:
        report(f"{damage.file.name}: damaged in the cache, fetched anew")
        discard(damage)
    return None if damaged else present


def remote_files(entry: CatalogueEntry) -> list[RemoteFile]:
    """The files of a model as the hub describes them now; nothing is fetched. Raises BadInput, also where one is not
    what the catalogue knows."""
    with as_bad_input(entry):
        return [_remote_file(entry, name) for name in _names(entry)]


def require_room(files: Sequence[tuple[CatalogueEntry, RemoteFile]]) -> None:
    """Raise BadInput where the disk has no room for what is lacking of all files together."""
    n_bytes = sum(file.n_bytes - _held_bytes(entry, file) for entry, file in files)
    folder = next(path for path in (cache_folder(), *cache_folder().parents) if path.exists())
    _require_room(", ".join(Path(file.name).name for _, file in files), n_bytes, folder)


def _held_bytes(entry: CatalogueEntry, file: RemoteFile) -> int:
    """How much of a file is in the cache."""
    blob = _blob(entry, file)
    if blob.exists():
        return file.n_bytes
    partial = _partial(blob)
    held = partial.stat().st_size if partial.exists() else 0
    return held if held <= file.n_bytes else 0


def _blob(entry: CatalogueEntry, file: RemoteFile) -> Path:
    return cache_folder() / repo_folder_name(repo_id=entry.repo, repo_type="model") / "blobs" / file.published


def _partial(blob: Path) -> Path:
    return blob.with_name(f"{blob.name}.incomplete")


def _require_room(what: str, n_bytes: int, folder: Path) -> None:
    free = shutil.disk_usage(folder).free
    if free < n_bytes:
        raise BadInput(
            f"no room for {what}: {n_bytes / 1e6:.0f} MB are needed and {free / 1e6:.0f} MB free at {cache_folder()}; "
            "free some, or set HF_HOME to a folder on another disk"
        )


def _names(entry: CatalogueEntry) -> list[str]:
    """The names of the files; patterns are filled in from the hub's listing, without its subfolders."""
    if not entry.patterns:
        return list(entry.files)
    listing = HfApi().list_repo_tree(entry.repo, revision=entry.revision)
    present = [item.path for item in listing if isinstance(item, RepoFile)]
    for pattern in entry.files:
        if not any(fnmatch(name, pattern) for name in present):
            raise BadInput(f"{entry.repo} at {entry.revision} holds no {pattern}: it is not the model it was")
    return [name for name in present if any(fnmatch(name, pattern) for pattern in entry.files)]


def _remote_file(entry: CatalogueEntry, name: str) -> RemoteFile:
    metadata: HfFileMetadata = get_hf_file_metadata(hf_hub_url(entry.repo, name, revision=entry.revision))
    expected = entry.sha256.get(name)
    if not metadata.etag or metadata.size is None:
        raise BadInput(f"{entry.repo}/{name}: the server names no checksum or size; is HF_ENDPOINT a hub?")
    if expected and metadata.etag != expected:
        raise BadInput(f"{entry.repo}/{name} is not what it was: checksum {metadata.etag}, expected {expected}")
    return RemoteFile(name, metadata.etag, metadata.size)


def _fetch_file(entry: CatalogueEntry, file: RemoteFile, report: Callable[[str], None]) -> None:
    """Bring one file into the cache. Another process that wants the same waits."""
    folder = repo_folder_name(repo_id=entry.repo, repo_type="model")
    blob = _blob(entry, file)
    lock = cache_folder() / ".locks" / folder / f"{file.published}.part.lock"
    blob.parent.mkdir(parents=True, exist_ok=True)
    lock.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(lock):
        if not blob.exists():
            partial = _partial(blob)
            _download(entry, file, partial, report)
            _check(entry, file, partial)
            partial.rename(blob)
    hf_hub_download(entry.repo, file.name, revision=entry.revision)  # the content is there: this only links it


def _download(entry: CatalogueEntry, file: RemoteFile, partial: Path, report: Callable[[str], None]) -> None:
    """Append to `partial` what it still lacks."""
    held = _held_bytes(entry, file)
    if partial.exists() and partial.stat().st_size > file.n_bytes:
        partial.unlink()
    _require_room(file.name, file.n_bytes - held, partial.parent)
    report(f"{file.name}: {file.n_bytes / 1e6:.1f} MB" + (f", {held / 1e6:.1f} of them here already" if held else ""))
    url = hf_hub_url(entry.repo, file.name, revision=entry.revision)
    with partial.open("ab") as target:
        http_get(
            url,
            target,
            resume_size=held,
            headers=build_hf_headers(),
            expected_size=file.n_bytes,
            displayed_filename=Path(file.name).name,
        )


def _check(entry: CatalogueEntry, file: RemoteFile, partial: Path) -> None:
    kind = checksum_kind(file.published)
    if kind and (actual := checksum(partial, kind)) != file.published:
        partial.unlink()
        raise BadInput(
            f"{entry.repo}/{file.name} came damaged: {kind} {actual}, expected {file.published}; it is deleted, "
            "run the command again"
        )
