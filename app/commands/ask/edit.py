"""`razer edit`: hand edits of a map, and their log."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from app.console.outputs import print_next, print_outputs
from app.console.streams import result_console
from app.console.waiting import waiting_for
from app.next_steps import looking_at
from app.settings.options import Flag
from razer.errors import BadInput

if TYPE_CHECKING:
    from razer.edits.log import EditLog

FORMAT = 1
OUTPUTS = {"edits.jsonl": "the log of all edits, which every verb applies", "mesh.glb": "the edited map for viewers"}
Change = Literal["rename", "relabel", "merge", "delete", "split", "move_border", "undo", "redo", "log"]


def edit(
    run: Path,
    change: Change,
    /,
    *arguments: str,
    plane: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    author: str = "",
    json: Flag = False,
) -> int:
    """Change a map by hand. Edits are kept in edits.jsonl beside it, and every verb that opens the map applies them.

    Parameters
    ----------
    run:
        The folder of a finished run, or of a saved map.
    change:
        rename ID NAME; relabel ID CLASS, which decides about stuff, too; merge KEPT_ID ID ...; delete ID; split ID
        and move_border FROM_ID TO_ID with --plane; undo; redo; log.
    arguments:
        Ids, names.
    plane:
        "nx ny nz offset_m", metres in world axes: the side where n.x >= offset_m becomes an instance of its own, or is
        given to the other.
    author:
        Who edits, for the log.
    json:
        One line of JSON.
    """
    if change == "log":
        return _list(run, arguments, json)
    from app.editing.arguments import typed_edit
    from app.editing.edit_run import edit_run, told

    if change in ("undo", "redo") and (arguments or plane is not None):
        raise BadInput(f"write it as: razer edit RUN {change}")
    what = change if change in ("undo", "redo") else typed_edit(change, arguments, plane)
    with waiting_for("opening the map and changing it"):
        entry, log = edit_run(run, what, author)
    if json:
        print(dumps({"format": FORMAT, "epoch": log.epoch, "edit": log.listed()[-1]}))
    else:
        result_console().print(told(run, entry, log), soft_wrap=True)
        print_outputs(run, OUTPUTS)
        print_next(("edit", run, "redo" if entry.kind == "undo" else "undo"), looking_at(run))
    return 0


def _list(run: Path, arguments: tuple[str, ...], json: bool) -> int:
    from razer.edits.conflicts import account
    from razer.edits.log import EditLog
    from razer.storage.file_names import require_map_folder

    if arguments:
        raise BadInput("write it as: razer edit RUN log")
    require_map_folder(run)
    log = EditLog.read(run)
    if json:
        print(dumps(_listed(log)))
        return 0
    console, undone = result_console(), {edit["number"] for edit in log.listed() if edit["undone"]}
    for entry in log.entries:
        console.print(
            f"{entry.number}  {entry.time}  {f'{entry.author}: ' if entry.author else ''}{account(log, entry)}"
            f"{' (undone)' if entry.number in undone else ''}",
            soft_wrap=True,
        )
    if not log.entries:
        console.print("no edits yet")
    again = [("edit", run, "undo")] if log.undoable else [("edit", run, "redo")] if log.redoable else []
    print_next(*again, looking_at(run))
    return 0


def _listed(log: EditLog) -> dict[str, object]:
    can = {"can_undo": log.undoable is not None, "can_redo": log.redoable is not None}
    return {"format": FORMAT, "epoch": log.epoch, "edits": log.listed(), **can}
