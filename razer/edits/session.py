"""Editing a map: each edit is tried on the map as it is now, then logged; several editors see each other's."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np

from razer.edits.apply import Replay, free_id
from razer.edits.change import called, instance
from razer.edits.conflicts import refuse_missing, refuse_stale
from razer.edits.edit import Edit, MoveBorder, Split
from razer.edits.known_again import before
from razer.edits.log import EditLog, Entry, Reversal
from razer.edits.log_file import LockedLog, locked_log
from razer.errors import BadInput, EditConflict
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap

TOUCH_M = 0.06  # between two instances that touch: borders of masks leave a seam of a voxel or two


class EditSession:
    """A map of a folder with its log, for one editor of perhaps several, in this process or in others."""

    def __init__(self, folder: str | Path, unedited: PanopticMap) -> None:
        """Open the log beside a map; raises BadInput for a damaged one.

        Args:
            folder: of the run or the saved map.
            unedited: the map as the folder holds it, `razer.load_map(folder, edited=False)`.
        """
        self.folder = Path(folder)
        self._replay, self._lock = Replay(unedited), threading.Lock()
        self.log = EditLog.read(self.folder)
        self.panoptic = self._replay.of(self.log)

    @property
    def epoch(self) -> int:
        """The number of entries of the log as far as it was read."""
        return self.log.epoch

    def rebase(self, unedited: PanopticMap) -> None:
        """Go on with a newer map of the same place, such as one that has grown: its ids may be others."""
        with self._lock:
            self._replay = Replay(unedited)
            self.panoptic = self._replay.of(self.log)

    def refresh(self) -> bool:
        """Take in what others have logged since; whether there was anything."""
        with self._lock:
            return self._follow(EditLog.read(self.folder))

    def apply(self, edit: Edit, *, time: str, author: str = "", epoch: int | None = None) -> Entry:
        """Try an edit and log it.

        Args:
            edit: what to change.
            time: now, UTC as ISO 8601.
            author: who asks for it.
            epoch: that of the map which the author saw; None = the one that this session has.

        Raises:
            EditConflict: if one of its instances was changed since, saying by which edit.
            BadInput: if it is impossible, or the log cannot be written.
        """

        def entry(log: EditLog, seen: int) -> Entry:
            refuse_stale(log, seen, edit.touched)
            items = [self._instance(i) for i in edit.touched]
            _refuse_apart(self.panoptic, edit)
            numbered = edit.model_copy(update={"new": self._new_id()}) if isinstance(edit, Split) else edit
            known = {item.id: before(item, self.panoptic.mesh) for item in items}
            return Entry(log.epoch + 1, seen, time, author, numbered, self._replay.fingerprint, known)

        return self._append(entry, epoch)

    def undo(self, *, time: str, author: str = "", epoch: int | None = None) -> Entry:
        """Take back the last edit; raises EditConflict where there is none, and where others came since `epoch`."""
        return self._reverse("undo", time, author, epoch)

    def redo(self, *, time: str, author: str = "", epoch: int | None = None) -> Entry:
        """Do again what was undone last; raises as above."""
        return self._reverse("redo", time, author, epoch)

    def _reverse(self, kind: Literal["undo", "redo"], time: str, author: str, epoch: int | None) -> Entry:
        def entry(log: EditLog, seen: int) -> Entry:
            target = log.undoable if kind == "undo" else log.redoable
            if target is None:
                raise EditConflict(f"there is nothing to {kind}")
            if seen < log.epoch:
                raise EditConflict(f"edit {log.epoch} came since you looked: load the map anew")
            return Entry(log.epoch + 1, seen, time, author, Reversal(kind, target.number))

        return self._append(entry, epoch)

    def _append(self, make: Callable[[EditLog, int], Entry], epoch: int | None) -> Entry:
        with self._lock, locked_log(self.folder) as file:
            seen = self.epoch if epoch is None else epoch
            self._follow(file.log)
            entry = make(file.log, seen)
            self._carry_out(file, entry)
            return entry

    def _carry_out(self, file: LockedLog, entry: Entry) -> None:
        """Try an entry on the map, and then write it."""
        log = file.log.appended(entry)
        if isinstance(entry.change, Reversal):
            panoptic = self._replay.of(log)
        else:
            state = self._replay.step(self.panoptic, entry)
            panoptic = self._replay.finished(state, log, self.panoptic.edit_problems)
        file.append(entry)
        self.log, self.panoptic = log, panoptic

    def _follow(self, log: EditLog) -> bool:
        if log.epoch == self.log.epoch:
            return False
        self.log, self.panoptic = log, self._replay.of(log)
        return True

    def _instance(self, number: int) -> MapObject:
        try:
            return instance(self.panoptic, number)
        except BadInput:
            refuse_missing(self.log, number)
            raise

    def _new_id(self) -> int:
        """An id that nothing has or ever had, so that no edit can mean another instance by it."""
        made = [entry.change.new or 0 for entry in self.log.entries if isinstance(entry.change, Split)]
        return max(free_id(self._replay.base), free_id(self.panoptic), max(made, default=0) + 1)


def _refuse_apart(panoptic: PanopticMap, edit: Edit) -> None:
    """Raise BadInput for a border between two instances that have none."""
    if not isinstance(edit, MoveBorder):
        return
    source, target = instance(panoptic, edit.source), instance(panoptic, edit.target)
    if source.id == target.id:
        raise BadInput("a border is between two instances: name another")
    if source.is_stuff and target.is_stuff:
        return
    from scipy.spatial import KDTree  # late: opening a map need not load it

    one, other = (panoptic.mesh.vertices[panoptic.mesh.instances == i] for i in (source.id, target.id))
    gaps_m = KDTree(one).query(other)[0] if len(one) and len(other) else np.zeros(0)
    if gaps_m.min(initial=np.inf) > TOUCH_M:
        raise BadInput(f"{called(source)} and {called(target)} do not touch, so that there is no border to move")
