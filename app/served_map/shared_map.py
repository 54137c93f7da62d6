"""The one loaded map of a run folder: opened once, replaced as a whole when its files change."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from app.query.negative_prompt_cache import negative_prompts_of
from app.query.queryable_map import open_map
from app.run_folder import run_folder as names
from app.served_map.asked_map import AskedMap
from app.served_map.crop_pictures import CropPictures
from app.served_map.edit_desk import EditDesk
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap
from razer.plugins import NO_TRUST, Trust
from razer.query.text_queries import TextQueryEncoder

Fingerprint = tuple[tuple[int, int] | None, ...]
_WATCHED = (names.INSTANCES, names.MESH_PLY, "edits.jsonl")


class SharedMap:
    """Gives the map as it is now; whoever holds an older one keeps it until done."""

    def __init__(self, folder: Path, *, trust: Trust = NO_TRUST) -> None:
        """Open the map; raises BadInput."""
        self.folder, self._trust = folder, trust
        self._lock = threading.Lock()
        self._encoder: TextQueryEncoder | None = None
        self._listeners: list[Callable[[AskedMap], None]] = []
        self.edits = EditDesk(folder)
        self._fingerprint = self._look()
        self._current = self._open()

    @property
    def current(self) -> AskedMap:
        """The map; opened anew if its files have changed, as after an edit."""
        if self._look() != self._fingerprint:
            self._reopen()
        return self._current

    def on_change(self, listener: Callable[[AskedMap], None]) -> None:
        """Call `listener` with each map that takes the place of another, from whichever thread notices."""
        self._listeners.append(listener)

    def _reopen(self) -> None:
        with self._lock:
            seen = self._look()
            if seen == self._fingerprint:
                return
            try:
                self._current = self._open()
            except BadInput:  # half of a change, or a damaged file: the map that was opened goes on
                return
            finally:
                self._fingerprint = seen
        for listener in self._listeners:
            listener(self._current)

    def _look(self) -> Fingerprint:
        return tuple(_stat(self.folder / name) for name in _WATCHED)

    def _open(self) -> AskedMap:
        epoch = self.edits.epoch()
        panoptic, config = open_map(self.folder, trust=self._trust)
        if self._encoder is None:
            self._encoder = _encoder(panoptic, config)
        panoptic = replace(panoptic, text_queries=self._encoder)
        return AskedMap(epoch, panoptic, CropPictures(self.folder, config.input))


def _encoder(panoptic: PanopticMap, config: RunConfig) -> TextQueryEncoder:
    """The text encoder with its negative prompts from the disk cache; without them if it knows no words."""
    assert panoptic.text_queries is not None
    try:
        negatives = negative_prompts_of(panoptic.text_queries, config.embedder)
    except BadInput:
        return panoptic.text_queries
    return TextQueryEncoder(panoptic.text_queries.embedder, negatives)


def _stat(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
