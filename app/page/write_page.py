"""Writing the page of a run to a file."""

from __future__ import annotations

from pathlib import Path

from app.page.html import page_html
from app.page.payload import page_payload
from app.run_folder.folder_lock import require_writable
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content


def write_page(run: Path, target: Path) -> int:
    """Write the offline page of a run, whole or not at all; returns its bytes. Raises BadInput naming what is missing
    or damaged, or the file that cannot be written."""
    if target.is_dir() or not target.parent.is_dir():
        raise BadInput(f"{target} cannot be written: give a file such as map.html in a folder that exists")
    require_writable(target)
    content = page_html("inline", page_payload(run), f"{run.absolute().name} · RAZER")
    try:
        replace_content(target, content)
    except OSError as error:
        raise BadInput(f"{target} cannot be written ({error.strerror}): give another file with --page") from None
    return len(content.encode())
