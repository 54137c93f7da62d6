"""Editing a run folder: the edit is logged, and the files for other programs follow it."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from app.run_folder import run_folder as names
from razer.edits.conflicts import account
from razer.edits.edit import Edit
from razer.edits.log import EditLog, Entry
from razer.edits.session import EditSession
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap
from razer.saved_map import load_map
from razer.storage.atomic_files import replace_file


def now_utc() -> str:
    """The time as the log has it."""
    return datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


def open_session(folder: Path) -> EditSession:
    """A run opened for editing; raises BadInput."""
    return EditSession(folder, load_map(folder, edited=False))


def edit_run(folder: Path, change: Edit | str, author: str) -> tuple[Entry, EditLog]:
    """Apply an edit, or "undo" or "redo", to a run, whose mesh.glb is renewed; the entry and the log that it ends.
    Raises BadInput, and then nothing was changed."""
    session = open_session(folder)
    if isinstance(change, str):
        entry = (session.undo if change == "undo" else session.redo)(time=now_utc(), author=author)
    else:
        entry = session.apply(change, time=now_utc(), author=author)
    if (folder / names.MESH_GLB).is_file():
        renew_glb(folder, session.panoptic)
    return entry, session.log


def renew_glb(folder: Path, panoptic: PanopticMap) -> None:
    """Write the mesh.glb of a run anew, from its edited map; raises BadInput."""
    from app.render.glb import write_map_glb  # late: the log is shown without it

    try:
        replace_file(folder / names.MESH_GLB, lambda path: write_map_glb(path, panoptic))
    except OSError as error:
        problem = f"the edit is made, but {folder / names.MESH_GLB} cannot be written ({error.strerror})"
        raise BadInput(f"{problem}: the next edit renews it") from error


def told(folder: Path, entry: Entry, log: EditLog) -> str:
    """One line: what was changed, and which files do not know of it."""
    line = f"edit {entry.number}: {account(log, entry)}"
    if (folder / names.PANOPTIC).is_file():
        line += f"; {names.PANOPTIC} and its kin are older: `razer label` renews them"
    return line
