"""Edits as JSON: what is asked for, and what the log holds."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from razer.edits.edit import Delete, Edit, Merge, MoveBorder, Relabel, Rename, Split, edit_of

MAX_AUTHOR = 60  # characters
_RENAME: JsonDict = {"kind": "rename", "epoch": 0, "author": "Ada", "instance": 12, "name": "office chair"}
_DONE: JsonDict = {
    "format": 1,
    "epoch": 1,
    "edit": {
        "number": 1,
        "epoch": 0,
        "time": "2026-11-22T10:00:00Z",
        "author": "Ada",
        "kind": "rename",
        "instance": 12,
        "name": "office chair",
        "undone": False,
    },
}


def _plain(text: str) -> str:
    return "".join(c for c in " ".join(text.split()) if c.isprintable())


Author = Annotated[str, Field(max_length=MAX_AUTHOR), AfterValidator(_plain)]
Epoch = Annotated[int, Field(ge=0, lt=2**53, strict=True, description="That of the map which the author saw.")]


class EditStamp(BaseModel):
    """Who asks for an edit, and of which state of the map."""

    epoch: Epoch
    author: Author = ""

    def edit(self) -> Edit:
        """The edit itself."""
        asked = self.model_dump(by_alias=True, exclude_none=True, exclude={"epoch", "author", "new"})
        return edit_of(asked)


class RenameRequest(EditStamp, Rename):
    """Give an instance another name; a thing stays a thing."""

    model_config = ConfigDict(json_schema_extra={"examples": [_RENAME]})


class RelabelRequest(EditStamp, Relabel):
    """Give an instance another class, which says whether it is stuff, too."""


class MergeRequest(EditStamp, Merge):
    """Let the first instance take in the others."""


class DeleteRequest(EditStamp, Delete):
    """Remove an instance; its surface becomes nobody's."""


class SplitRequest(EditStamp, Split):
    """Make what of an instance lies in a region an instance of its own."""


class MoveBorderRequest(EditStamp, MoveBorder):
    """Give what of one instance lies in a region to another."""


EditRequest = Annotated[
    RenameRequest | RelabelRequest | MergeRequest | DeleteRequest | SplitRequest | MoveBorderRequest,
    Field(discriminator="kind"),
]


class EditEntry(BaseModel):
    """An entry of the log; the rest of it depends on the kind."""

    model_config = ConfigDict(extra="allow")

    number: int
    epoch: int
    time: str
    author: str
    kind: str
    undone: bool


class EditList(BaseModel):
    """The edit log."""

    format: Literal[1] = 1
    epoch: int
    edits: list[EditEntry]
    problems: list[str] = Field(description="Which of them could not be applied to the map as it is now, and why.")
    can_undo: bool
    can_redo: bool


class EditDone(BaseModel):
    """An edit that was made, and the epoch of the map since."""

    model_config = ConfigDict(json_schema_extra={"examples": [_DONE]})

    format: Literal[1] = 1
    epoch: int
    edit: EditEntry


def entry_of(listed: dict[str, Any]) -> EditEntry:
    """An entry as the log lists it."""
    return EditEntry.model_validate(listed)


def told(last: EditEntry | None, epoch: int) -> dict[str, Any]:
    """The event that tells of a changed map."""
    kind, author = ("reload", "") if last is None else (last.kind, last.author)
    return {"epoch": epoch, "kind": kind, "author": author}
