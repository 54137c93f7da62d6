"""Edits as they are typed: `rename 12 "office chair"`, `split 3 --plane "1 0 0 0.5"`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from razer.edits.edit import Edit, edit_of
from razer.errors import BadInput

# What follows the verb, for messages; `...` = one or more.
USAGE = {
    "rename": "ID NAME",
    "relabel": "ID CLASS",
    "merge": "KEPT_ID ID ...",
    "delete": "ID",
    "split": 'ID --plane "nx ny nz offset_m"',
    "move_border": 'FROM_ID TO_ID --plane "nx ny nz offset_m"',
}
_N_ARGUMENTS = {"rename": 2, "relabel": 2, "delete": 1, "split": 1, "move_border": 2}


def typed_edit(change: str, arguments: Sequence[str], plane: str | None) -> Edit:
    """The edit that some words mean; raises BadInput that says how it is written."""
    usage = f"write it as: razer edit RUN {change} {USAGE[change]}"
    n_missing = len(arguments) < 2 if change == "merge" else len(arguments) != _N_ARGUMENTS[change]
    if n_missing or (plane is None) == (change in ("split", "move_border")):
        raise BadInput(usage)
    content: dict[str, Any] = {"kind": change}
    if plane is not None:
        content["region"] = {"plane": _plane(plane)}
    match change:
        case "rename" | "relabel":
            content |= {"instance": _id(arguments[0]), "name" if change == "rename" else "class": arguments[1]}
        case "merge":
            content["instances"] = [_id(argument) for argument in arguments]
        case "move_border":
            content |= {"from": _id(arguments[0]), "to": _id(arguments[1])}
        case _:
            content["instance"] = _id(arguments[0])
    return edit_of(content)


def _id(text: str) -> int:
    if not text.removeprefix("#").isdecimal():
        raise BadInput(f"{text} is no id of an instance: `razer query` and instances.json have them")
    return int(text.removeprefix("#"))


def _plane(text: str) -> dict[str, object]:
    try:
        x, y, z, offset_m = (float(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise BadInput(
            f'--plane {text}: write it as "nx ny nz offset_m", the side where n.x >= offset_m is taken'
        ) from None
    return {"normal": (x, y, z), "offset_m": offset_m}
