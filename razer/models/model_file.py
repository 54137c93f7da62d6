"""From what the option `weights` says to where the model lies."""

from __future__ import annotations

import re
from pathlib import Path

from razer.frame import BadInput

_HUB_ID = re.compile(r"[\w.-]+/[\w.-]+")


def model_file(name_or_path: str | Path) -> Path:
    """Where a model lies: a path that exists as it stands, or a hub id such as "openai/clip-vit-base-patch32" that is
    in the Hugging Face cache, whose folder it gives. Raises BadInput."""
    path, name = Path(name_or_path).expanduser(), str(name_or_path)
    if path.exists():
        return path
    if not _HUB_ID.fullmatch(name):
        raise BadInput(f"no model file {path}: give a file, a folder or a hub id")
    try:
        from huggingface_hub import snapshot_download
        from huggingface_hub.errors import LocalEntryNotFoundError
    except ImportError:
        raise BadInput(f"no file or folder {path}, and hub ids need: pip install 'razer[clip]'") from None
    try:
        return Path(snapshot_download(name, local_files_only=True))
    except LocalEntryNotFoundError:
        raise BadInput(
            f"no file or folder {path}, and not in the Hugging Face cache: run 'hf download {name}'"
        ) from None
