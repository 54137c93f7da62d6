"""Lookup in the local Hugging Face cache, without the network."""

from __future__ import annotations

from fnmatch import fnmatch
from pathlib import Path

from huggingface_hub import constants
from huggingface_hub.file_download import repo_folder_name

from razer.files import read_text
from razer.models.hub.catalogue import CatalogueEntry


def cache_folder() -> Path:
    """Where the cache lies: HF_HUB_CACHE, else below HF_HOME, else below the home folder."""
    return Path(constants.HF_HUB_CACHE).expanduser()


def cached_snapshot(repo: str, revision: str = "main") -> Path | None:
    """The folder of a repository at a revision; None if nothing of it is in the cache."""
    folder = cache_folder() / repo_folder_name(repo_id=repo, repo_type="model")
    reference = folder / "refs" / revision
    commit = read_text(reference).strip() if reference.is_file() else revision
    snapshot = folder / "snapshots" / commit
    return snapshot if snapshot.is_dir() else None


def cached_model(entry: CatalogueEntry) -> Path | None:
    """The file of a model that is one file, else the folder of its files; None while any is missing.

    Of files named by patterns it is enough that each pattern matches one: the largest, the weights, are fetched last.
    """
    folder = cached_snapshot(entry.repo, entry.revision)
    if folder is None:
        return None
    present = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()]
    if not all(any(fnmatch(name, pattern) for name in present) for pattern in entry.files):
        return None
    return folder if entry.patterns or len(entry.files) > 1 else folder / entry.files[0]
