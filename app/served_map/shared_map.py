"""The one loaded map of a run folder: opened once, replaced as a whole when it is edited or made anew."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path
from time import monotonic

from app.editing.edit_run import now_utc, renew_glb
from app.page.payload import page_payload
from app.query.negative_prompt_cache import negative_prompts_of
from app.query.queryable_map import open_map
from app.run_folder import run_folder as names
from app.served_map.asked_map import AskedMap, NoSuchInstance
from app.served_map.crop_pictures import CropPictures
from app.served_map.edit_models import EditDone, EditEntry, EditList, EditStamp, entry_of
from app.settings.run_config import RunConfig
from razer.edits.log import EditLog, Entry
from razer.edits.session import EditSession
from razer.errors import BadInput, UntrustedPlugin
from razer.panoptic_map import PanopticMap
from razer.plugins import NO_TRUST, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.storage.file_names import EDITS

CALM_S = 3.0
Fingerprint = tuple[tuple[int, int] | None, ...]
Listener = Callable[[EditEntry | None, int], None]


class SharedMap:
    """Gives the map as it is now; whoever holds an older one keeps it until done. Safe from several threads."""

    def __init__(self, folder: Path, *, trust: Trust = NO_TRUST) -> None:
        """Open the map; raises BadInput."""
        self.folder, self._trust = folder, trust
        self._lock = threading.RLock()
        self._encoder: TextQueryEncoder | None = None
        self._listeners: list[Listener] = []
        self._seen = self._look(), _stat(folder / EDITS)
        self._edited_s = inf  # when it was edited last, since files follow
        self._session, self._crops = self._open()
        self._current = self._asked()

    @property
    def current(self) -> AskedMap:
        """The map; followed up first where its files have changed, as by another program."""
        if (self._look(), _stat(self.folder / EDITS)) != self._seen:
            self._follow()
        return self._current

    def on_change(self, listener: Listener) -> None:
        """Call `listener` with the last edit, if any, and the epoch of each map that takes the place of another, from
        whichever thread notices."""
        self._listeners.append(listener)

    def page(self) -> bytes:
        """The data of the page, as it is now."""
        current = self.current
        return current.once("page", lambda: page_payload(self.folder, current.epoch, (current.panoptic, self._config)))

    def changes(self, since: int) -> bytes:
        """Nothing: a finished map does not grow. Raises NoSuchInstance."""
        raise NoSuchInstance("this map does not grow")

    @property
    def edits(self) -> EditList:
        """The edit log."""
        _ = self.current
        return listed(self._session.log, self._session.panoptic)

    def edit(self, request: EditStamp) -> EditDone:
        """Make an edit; raises EditConflict where its author saw too old a map, BadInput where it is impossible."""
        change = request.edit()
        return self._change(
            lambda: self._session.apply(change, time=now_utc(), author=request.author, epoch=request.epoch)
        )

    def undo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Take back the last edit; raises EditConflict where there is none."""
        return self._change(lambda: self._session.undo(time=now_utc(), author=author, epoch=epoch))

    def redo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Do again what was undone last; raises EditConflict where nothing was."""
        return self._change(lambda: self._session.redo(time=now_utc(), author=author, epoch=epoch))

    def tend(self) -> None:
        """Notice what other programs changed; once nobody has edited for a while, let mesh.glb follow."""
        _ = self.current
        if monotonic() - self._edited_s > CALM_S:
            self.renew_files()

    def renew_files(self) -> None:
        """Let mesh.glb follow the edits, for other programs; raises BadInput where it cannot be written."""
        with self._lock:
            is_old, self._edited_s = self._edited_s < inf, inf
            panoptic = self._session.panoptic
        if is_old and (self.folder / names.MESH_GLB).is_file():
            renew_glb(self.folder, panoptic)

    def _change(self, make: Callable[[], Entry]) -> EditDone:
        with self._lock:
            entry = make()
            self._swap()
            self._edited_s = monotonic()
            done = entry_of(self._session.log.listed()[entry.number - 1])
        self._tell()
        return EditDone(epoch=entry.number, edit=done)

    def _follow(self) -> None:
        with self._lock:
            files, edits = self._look(), _stat(self.folder / EDITS)
            if (files, edits) == self._seen:
                return
            try:
                if files != self._seen[0]:
                    self._session, self._crops = self._open()
                elif not self._session.refresh() and self._is_of_session():
                    self._seen = files, edits
                    return
                self._swap()
            except BadInput:  # half of a change, or a damaged file: the map that is open goes on
                self._seen = files, edits
                return
        self._tell()

    def _is_of_session(self) -> bool:
        # An edit that was refused has taken in what others logged, without a map for those who ask.
        return self._session.epoch == self._current.epoch

    def _swap(self) -> None:
        self._current = self._asked()
        self._seen = self._look(), _stat(self.folder / EDITS)

    def _tell(self) -> None:
        log = self._session.log
        last = entry_of(log.listed()[-1]) if log.entries else None
        for listener in self._listeners:
            listener(last, log.epoch)

    def _look(self) -> Fingerprint:
        return tuple(_stat(self.folder / name) for name in (names.INSTANCES, names.MESH_PLY))

    def _asked(self) -> AskedMap:
        return AskedMap(self._session.epoch, self._session.panoptic, self._crops)

    def _open(self) -> tuple[EditSession, CropPictures]:
        panoptic, config = open_map(self.folder, edited=False, trust=self._trust)
        if self._encoder is None:
            self._encoder = _encoder(panoptic, config)
        self._config = config
        session = EditSession(self.folder, replace(panoptic, text_queries=self._encoder))
        return session, CropPictures(self.folder, config.input)


def listed(log: EditLog, panoptic: PanopticMap) -> EditList:
    """A log as JSON, and which of it a map could not take."""
    return EditList(
        epoch=log.epoch,
        edits=[entry_of(entry) for entry in log.listed()],
        problems=list(panoptic.edit_problems),
        can_undo=log.undoable is not None,
        can_redo=log.redoable is not None,
    )


def _encoder(panoptic: PanopticMap, config: RunConfig) -> TextQueryEncoder:
    """The text encoder with its negative prompts from the disk cache; without them if it knows no words."""
    assert panoptic.text_queries is not None
    try:
        negatives = negative_prompts_of(panoptic.text_queries, config.embedder)
    except UntrustedPlugin:
        raise
    except BadInput:
        return panoptic.text_queries
    return TextQueryEncoder(panoptic.text_queries.embedder, negatives)


def _stat(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
