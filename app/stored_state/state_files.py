"""Files of one process's state: a tree as JSON, and the packs of its arrays."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from app.stored_state.array_packs import PackReader, PackWriter
from app.stored_state.saved_state import SavedState, tree_path
from app.stored_state.state_codec import Decoder, Encoder, KnownObjects
from razer.errors import BadInput
from razer.files import read_json

_MAX_DEPTH = 400  # two for each object in another


class StateWriter:
    """Saves the state of one process, `name`, again and again; until `tidy`, the one before stays."""

    def __init__(self, folder: Path, name: str, known: KnownObjects) -> None:
        self._folder, self._name, self._known = folder, name, known
        self._packs = PackWriter(folder, name)
        self._number = -1

    def save(self, state: object) -> SavedState:
        """Write a state; raises OSError where that fails, which leaves the one before whole."""
        self._number = self._packs.begin()
        try:
            tree = Encoder(self._known, self._packs).encode(state)
            packs = self._packs.finish()
            _write_safely(tree_path(self._folder, self._name, self._number), json.dumps(tree).encode())
        except BaseException:
            self._packs.abandon()
            raise
        return SavedState(self._name, self._number, tuple(packs))


def load_state(folder: Path, saved: SavedState, known: KnownObjects) -> Any:
    """The state as it was; raises BadInput for files that are missing or damaged."""
    path = tree_path(folder, saved.name, saved.number)
    try:
        tree = read_json(path, only_finite=False, max_depth=_MAX_DEPTH)
    except BadInput as error:
        raise BadInput(f"{error}; the checkpoint cannot be used") from None
    try:
        return Decoder(known, PackReader(folder, saved.name)).decode(tree)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _write_safely(path: Path, data: bytes) -> None:
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
