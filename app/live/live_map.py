"""A map that grows, and then is finished: what is asked of it is answered from the last snapshot."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.editing.edit_run import now_utc
from app.live.growing_mesh import GrowingMesh
from app.live.mesh_blocks import encode_blocks
from app.live.snapshot import Snapshot
from app.page.payload import growing_payload
from app.served_map.asked_map import AskedMap, NoSuchInstance
from app.served_map.crop_pictures import NoPictures
from app.served_map.edit_models import EditDone, EditList, EditStamp, entry_of
from app.served_map.shared_map import SharedMap, listed
from app.settings.run_config import RunConfig
from razer.edits.edit import Edit
from razer.edits.log import Entry
from razer.edits.session import EditSession
from razer.errors import EditConflict
from razer.models import embedder_of
from razer.panoptic_map import PanopticMap
from razer.plugins import Trust
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.gravity import up_direction

_SETTLE_S = 60.0
Announce = Callable[[str, dict[str, Any]], None]


class LiveMap:
    """The map of a run that goes on in another process. Safe from several threads."""

    def __init__(self, folder: Path, config: RunConfig, announce: Announce) -> None:
        """`folder` is the unfinished one of the run: edits are kept there, and go with it when it is renamed."""
        self._folder, self._announce = folder, announce
        self._title = Path(config.input.folder or folder).name
        self._lock = threading.RLock()
        self._mesh = GrowingMesh()
        self._snapshot: Snapshot | None = None
        self._known: set[int] = set()
        self._encoder = TextQueryEncoder.deferred(lambda: embedder_of(config.embedder))
        self._session: EditSession | None = None
        self._epoch = 0
        self._asked: AskedMap | None = None
        self._finished: SharedMap | None = None
        self._is_settled = threading.Event()

    def take(self, snapshot: Snapshot) -> None:
        """Go on from the next snapshot, and tell of it."""
        with self._lock:
            self._mesh.take(snapshot)
            self._snapshot = snapshot
            self._session = self._asked = None
            revision, born = self._mesh.revision, [o for o in snapshot.objects if o.id not in self._known]
            self._known.update(o.id for o in born)
        self._announce("map", {"epoch": self._epoch, "frame": snapshot.frame, "revision": revision})
        for item in born:
            self._announce(
                "instance", {"id": item.id, "name": item.class_name or "thing", "born_frame": item.first_frame}
            )

    def finish(self, folder: Path, trust: Trust) -> SharedMap:
        """Go on from the finished run in a folder; raises BadInput where it cannot be opened."""
        try:
            finished = SharedMap(folder, trust=trust)
            with self._lock:
                self._finished = finished
        finally:
            self._is_settled.set()
        self._announce("edit", {"epoch": finished.current.epoch, "kind": "finished", "author": ""})
        return finished

    @property
    def current(self) -> AskedMap:
        """The map as it is now."""
        self._settle()
        with self._lock:
            if self._finished is not None:
                return self._finished.current
            if self._asked is None or self._opened().refresh():
                session = self._opened()
                self._asked = AskedMap(session.epoch, session.panoptic, NoPictures())
            return self._asked

    def tend(self) -> None:
        """Tend the finished map; of one that grows nothing is left to do."""
        if self._finished is not None:
            self._finished.tend()

    def page(self) -> bytes:
        """The data of the page: of a growing map all but the mesh, which comes as changes since revision 0."""
        with self._lock:
            if self._finished is not None:
                return self._finished.page()
            current = self.current
            return growing_payload(current.panoptic, self._title, current.epoch)

    def changes(self, since: int) -> bytes:
        """The blocks of the mesh that changed after a revision; raises NoSuchInstance where the map is finished."""
        with self._lock:
            if self._finished is not None:
                raise NoSuchInstance("the map does not grow any more: load the page anew")
            blocks, revision, epoch = self._mesh.changes(since), self._mesh.revision, self._epoch
        return encode_blocks(blocks, revision, epoch)

    @property
    def edits(self) -> EditList:
        """The edit log."""
        self._settle()
        with self._lock:
            if self._finished is not None:
                return self._finished.edits
            session = self._opened()
            return listed(session.log, session.panoptic)

    def edit(self, request: EditStamp) -> EditDone:
        """Make an edit; it stays with its instances as the map grows. Raises EditConflict, BadInput."""
        change, author, epoch = request.edit(), request.author, request.epoch
        self._settle()
        with self._lock:
            if self._finished is not None:
                return self._finished.edit(request)
            session = self._opened()
            _refuse_unseen(change, session.panoptic)
            return self._done(session.apply(change, time=now_utc(), author=author, epoch=epoch))

    def undo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Take back the last edit; raises EditConflict."""
        self._settle()
        with self._lock:
            if self._finished is not None:
                return self._finished.undo(author, epoch)
            return self._done(self._opened().undo(time=now_utc(), author=author, epoch=epoch))

    def redo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Do again what was undone last; raises EditConflict."""
        self._settle()
        with self._lock:
            if self._finished is not None:
                return self._finished.redo(author, epoch)
            return self._done(self._opened().redo(time=now_utc(), author=author, epoch=epoch))

    def _settle(self) -> None:
        """Wait for the finished map once the run has given its folder, and the edits in it, another name."""
        if self._finished is None and not self._folder.is_dir():
            self._is_settled.wait(_SETTLE_S)

    def _done(self, entry: Entry) -> EditDone:
        self._asked, self._epoch = None, entry.number
        done = entry_of(self._opened().log.listed()[entry.number - 1])
        self._announce("edit", {"epoch": entry.number, "kind": done.kind, "author": done.author})
        return EditDone(epoch=entry.number, edit=done)

    def _opened(self) -> EditSession:
        """The last snapshot with the edits so far."""
        if self._session is None:
            self._session = EditSession(self._folder, self._panoptic())
        self._epoch = self._session.epoch
        return self._session

    def _panoptic(self) -> PanopticMap:
        if self._snapshot is None:
            return PanopticMap((), GrowingMesh().whole(np.zeros(0, np.int32)), self._encoder)
        objects = self._snapshot.objects
        mesh = self._mesh.whole(np.array([o.id for o in objects], np.int32))
        counts = np.bincount(mesh.instances, minlength=max((o.id for o in objects), default=0) + 1)
        counted = tuple(replace(o, n_vertices=int(counts[o.id])) for o in sorted(objects, key=lambda o: o.id))
        guess = np.zeros(3) if self._snapshot.up is None else self._snapshot.up
        up = up_direction(mesh, guess)
        return PanopticMap(counted, mesh, self._encoder, up=up if up.any() else None)


def _refuse_unseen(edit: Edit, panoptic: PanopticMap) -> None:
    """Raise EditConflict where an instance has no surface yet: by what would it be known again later?"""
    unseen = [item.id for item in panoptic.objects if item.id in edit.touched and not item.n_vertices]
    if unseen:
        raise EditConflict(f"{unseen[0]} has no surface in the map yet: edit it when it is shown")
