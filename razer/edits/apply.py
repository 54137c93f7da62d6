"""Edits applied to a map: a log in, the map as people left it out."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from razer.edits.change import changed
from razer.edits.edit import Edit, Merge, Split
from razer.edits.known_again import KnownAgain, fingerprint
from razer.edits.log import EditLog, Entry, Reversal
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap

if TYPE_CHECKING:
    from razer.volume.voxel_map import VoxelMap


def apply_edits(panoptic: PanopticMap, log: EditLog) -> PanopticMap:
    """A map with all edits of a log that are not undone, to the byte the same where none is. An edit sticks to its
    instances: in a map whose ids are others they are known again by their surface. One that cannot be applied is left
    out, and `edit_problems` says why."""
    return Replay(panoptic).of(log)


class Replay:
    """Applies logs to one map, which stays as it is."""

    def __init__(self, panoptic: PanopticMap) -> None:
        self.base, self.fingerprint = panoptic, fingerprint(panoptic.mesh)
        self._again: KnownAgain | None = None

    def of(self, log: EditLog) -> PanopticMap:
        """The map with the edits of a log."""
        state, problems = self.base, []
        for entry in log.in_force:
            try:
                state = self.step(state, entry)
            except BadInput as error:
                problems.append(f"edit {entry.number} ({entry.kind}) is not applied: {error}")
        return self.finished(state, log, tuple(problems))

    def step(self, state: PanopticMap, entry: Entry) -> PanopticMap:
        """A map with one more edit; raises BadInput where it cannot be applied."""
        assert not isinstance(entry.change, Reversal)
        edit = entry.change if entry.fingerprint == self.fingerprint else self._translated(state, entry)
        return state if edit is None else changed(edit, state)

    def finished(self, state: PanopticMap, log: EditLog, problems: tuple[str, ...]) -> PanopticMap:
        """A map after the last edit, with its epoch, and its volume with the labels of the mesh."""
        state = replace(state, epoch=log.epoch, edit_problems=problems)
        open_volume, is_same = self.base.open_volume, state.mesh is self.base.mesh
        if open_volume is None or (is_same and len(state.objects) == len(self.base.objects)):
            return replace(state, open_volume=open_volume)
        return replace(state, open_volume=partial(_edited_volume, self.base, state))

    def _translated(self, state: PanopticMap, entry: Entry) -> Edit | None:
        """An edit of another map's ids; None where nothing is left to do. Raises BadInput for instances that are not
        there any more."""
        edit = entry.change
        assert not isinstance(edit, Reversal)
        self._again = self._again or KnownAgain(state.mesh.vertices.astype(np.float64))
        ids = self._again.ids(state.mesh, entry.before)
        if lost := [i for i in edit.touched if i not in ids]:
            raise BadInput(f"{entry.called(lost[0])} is not found in this map any more")
        edit = edit.on(ids)
        if isinstance(edit, Split):
            edit = edit.model_copy(update={"new": free_id(state, edit.new)})
        is_done = (isinstance(edit, Merge) and len(edit.instances) < 2) or len(set(edit.touched)) < len(edit.touched)
        return None if is_done else edit


def free_id(panoptic: PanopticMap, wanted: int | None = None) -> int:
    """An id that no instance and no part has: the one wanted, else the next after all of them."""
    taken = {item.id for item in (*panoptic.objects, *panoptic.parts)}
    return wanted if wanted is not None and wanted not in taken else max(taken, default=0) + 1


def _edited_volume(base: PanopticMap, edited: PanopticMap) -> VoxelMap:
    from razer.edits.volume_labels import relabelled  # late: it brings Open3D and torch along

    assert base.open_volume is not None
    gone = {item.id for item in base.objects} - {item.id for item in edited.objects}
    return relabelled(base.open_volume(), base.mesh, edited.mesh.instances, gone)
