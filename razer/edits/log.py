"""Edit log: what was changed by hand, by whom and when; undone edits stay in it, as edits that are undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from razer.arrays import Float64Array
from razer.edits.edit import Edit, Split, edit_of
from razer.errors import BadInput, one_line
from razer.files import MALFORMED, parse_json, read_bytes
from razer.storage.file_names import EDITS

FORMAT = 1
_MAX_BYTES = 64 * 2**20  # some hundred thousand edits: what is longer is no log
_FRAME = {"number", "epoch", "time", "author", "map", "about"}


@dataclass(frozen=True)
class Reversal:
    """An edit, by its number, that is undone, or done again."""

    kind: Literal["undo", "redo"]
    edit: int

    def to_json(self) -> dict[str, Any]:
        """As it stands in the log."""
        return {"kind": self.kind, "edit": self.edit}


@dataclass(frozen=True)
class Before:
    """An instance as an edit met it: its name, and points (N, 3) of its surface, metres, by which it is known again in
    a map whose ids are others."""

    name: str | None
    points: Float64Array

    def to_json(self) -> dict[str, Any]:
        """As it stands in the log, to the millimetre."""
        return {"name": self.name, "points": [[round(x, 3) for x in point] for point in self.points.tolist()]}


@dataclass(frozen=True)
class Entry:
    """One line of the log: number >= 1; epoch, the number of entries that its author knew of; time, UTC as ISO 8601;
    fingerprint of the map that it was made on; the instances as they were before it, by id."""

    number: int
    epoch: int
    time: str
    author: str
    change: Edit | Reversal
    fingerprint: str = ""
    before: Mapping[int, Before] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """rename, relabel, merge, delete, split, move_border, undo or redo."""
        return self.change.kind

    @property
    def touched(self) -> tuple[int, ...]:
        """The ids of the instances that an edit changes or makes; none of an undo."""
        if isinstance(self.change, Reversal):
            return ()
        made = (self.change.new,) if isinstance(self.change, Split) and self.change.new else ()
        return (*self.change.touched, *made)

    def called(self, instance: int) -> str:
        """An instance as the edit met it: "chair #12"."""
        name = self.before[instance].name if instance in self.before else None
        return f"{name or 'instance'} #{instance}"

    def to_json(self) -> dict[str, Any]:
        """The object that its line holds."""
        frame = {"number": self.number, "epoch": self.epoch, "time": self.time, "author": self.author}
        about = {"map": self.fingerprint, "about": {str(i): b.to_json() for i, b in self.before.items()}}
        return frame | self.change.to_json() | (about if self.before else {})


@dataclass(frozen=True)
class EditLog:
    """All entries, oldest first."""

    entries: tuple[Entry, ...] = ()

    @classmethod
    def read(cls, folder: str | Path) -> EditLog:
        """The log of a run or a saved map, empty where nothing was edited; raises BadInput for a damaged one."""
        path = Path(folder) / EDITS
        try:
            if not path.is_file():
                return cls()
            return cls.parsed(read_bytes(path, _MAX_BYTES))
        except BadInput as error:
            raise BadInput(f"{path} is damaged ({error}): mend it, or move it away to have the map unedited") from error
        except MALFORMED as error:
            problem = f"{path} is damaged ({one_line(error)})"
            raise BadInput(f"{problem}: mend it, or move it away to have the map unedited") from error

    @classmethod
    def parsed(cls, data: bytes) -> EditLog:
        """The log in a file's bytes; a last line that is not ended was never written. Raises one of MALFORMED
        for anything else than a log."""
        lines = data.split(b"\n")[:-1]
        if not lines:
            return cls()
        header = parse_json(lines[0], "line 1")
        if header.get("kind") != "log" or header["format"] != FORMAT:
            raise ValueError(f"its first line is no header of format {FORMAT}")
        entries = tuple(_entry(parse_json(line, f"line {n}")) for n, line in enumerate(lines[1:], start=2))
        if [entry.number for entry in entries] != list(range(1, len(entries) + 1)):
            raise ValueError("its entries are not numbered from 1 on")
        log = cls(entries)
        _ = log.in_force
        return log

    @property
    def epoch(self) -> int:
        """The number of entries: that of the map as they leave it."""
        return len(self.entries)

    def listed(self) -> list[dict[str, Any]]:
        """The entries as people and programs see them: without what instances are known again by, and with `undone`."""
        in_force = {entry.number for entry in self.in_force}
        listed = []
        for entry in self.entries:
            content = {key: value for key, value in entry.to_json().items() if key not in ("map", "about")}
            is_undone = not isinstance(entry.change, Reversal) and entry.number not in in_force
            listed.append(content | {"undone": is_undone})
        return listed

    def appended(self, entry: Entry) -> EditLog:
        """With one entry more."""
        return EditLog((*self.entries, entry))

    def entry(self, number: int) -> Entry:
        """One entry, by its number."""
        return self.entries[number - 1]

    @cached_property
    def _stacks(self) -> tuple[list[Entry], list[Entry]]:
        """What is done, in order, and what is undone, that undone last at the end."""
        done: list[Entry] = []
        undone: list[Entry] = []
        for entry in self.entries:
            if not isinstance(entry.change, Reversal):
                done.append(entry)
                undone.clear()
                continue
            source, target = (done, undone) if entry.kind == "undo" else (undone, done)
            if not source or source[-1].number != entry.change.edit:
                raise ValueError(f"entry {entry.number} cannot {entry.kind} edit {entry.change.edit}")
            target.append(source.pop())
        return done, undone

    @property
    def in_force(self) -> tuple[Entry, ...]:
        """The edits that are not undone, oldest first."""
        return tuple(self._stacks[0])

    @property
    def undoable(self) -> Entry | None:
        """The edit that an undo would take back."""
        return self._stacks[0][-1] if self._stacks[0] else None

    @property
    def redoable(self) -> Entry | None:
        """The edit that a redo would do again."""
        return self._stacks[1][-1] if self._stacks[1] else None


def _entry(content: Mapping[str, Any]) -> Entry:
    kind, rest = content["kind"], {key: value for key, value in content.items() if key not in _FRAME}
    number, epoch = int(content["number"]), int(content["epoch"])
    time, author = str(content["time"]), str(content["author"])
    if kind in ("undo", "redo"):
        return Entry(number, epoch, time, author, Reversal(kind, int(content["edit"])))
    before = {int(i): _before(b) for i, b in content.get("about", {}).items()}
    return Entry(number, epoch, time, author, edit_of(rest), str(content.get("map", "")), before)


def _before(content: Mapping[str, Any]) -> Before:
    points = np.array(content["points"], np.float64).reshape(-1, 3)
    if not np.isfinite(points).all() or not isinstance(content["name"], str | None):
        raise ValueError("it knows an instance by what is no name and points")
    return Before(content["name"], points)
