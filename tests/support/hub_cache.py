"""Models put into a Hugging Face cache as a download leaves them."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from razer.models.hub.catalogue import catalogue, entry
from tests.support.hub_server import COMMIT, LARGE, git_id
from tests.support.rfdetr_exports import CHAIR, CUP, logits, write_rfdetr


def put_into_cache(cache: Path, name: str, write: Callable[[Path], object]) -> Path:
    """The folder of an entry of the catalogue, which `write` fills."""
    model = entry(name)
    commit = COMMIT if model.revision == "main" else model.revision
    folder = cache / f"models--{model.repo.replace('/', '--')}"
    (folder / "refs").mkdir(parents=True, exist_ok=True)
    (folder / "refs" / model.revision).write_text(commit)
    snapshot = folder / "snapshots" / commit
    snapshot.mkdir(parents=True, exist_ok=True)
    write(snapshot)
    for file in [path for path in snapshot.rglob("*") if path.is_file()]:
        _keep_as_blob(file, folder / "blobs")
    return snapshot


def _keep_as_blob(file: Path, blobs: Path) -> None:
    """Move a file to where its checksum names it, and leave a link."""
    content = file.read_bytes()
    blob = blobs / (git_id(content) if len(content) < LARGE else hashlib.sha256(content).hexdigest())
    blobs.mkdir(exist_ok=True)
    file.rename(blob)
    file.symlink_to(os.path.relpath(blob, file.parent))


def without_checksums(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the catalogue know no checksums, so that made-up files may stand for its models."""
    known = {name: replace(each, sha256={}) for name, each in catalogue().items()}
    monkeypatch.setattr("razer.models.hub.model_file.catalogue", lambda: known)


def put_starter(cache: Path) -> None:
    """Small models with the files and signatures of the set "starter"."""
    from tests.support import clip_checkpoints, tiny_checkpoints  # late: they load transformers

    def clip(folder: Path) -> None:
        source = cache.with_name("clip")
        clip_checkpoints.clip_folder(source)
        clip_checkpoints.onnx_folder(folder, source)

    labels = logits([{CHAIR: 0.8}, {CUP: 0.7}])
    put_into_cache(cache, "rf-detr-seg-small", lambda folder: write_rfdetr(folder / "rfdetr-seg-small.onnx", labels))
    put_into_cache(cache, "upernet-convnext-tiny", tiny_checkpoints.upernet)
    put_into_cache(cache, "clip-vit-b32", clip)
