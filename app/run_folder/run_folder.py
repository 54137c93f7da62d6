"""The folder of one run: written beside its final place, and moved there when it is complete."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from pathlib import Path
from types import TracebackType

from app.run_folder.folder_lock import FolderLock, require_writable
from app.stored_state.checkpoint import FILE as CHECKPOINT_FILE
from app.stored_state.checkpoint import FOLDER as CHECKPOINT
from app.stored_state.checkpoint import Checkpoint, read_checkpoint
from razer.errors import BadInput
from razer.storage.atomic_files import replace_file
from razer.storage.file_names import CONFIG as CONFIG
from razer.storage.file_names import EMBEDDINGS as EMBEDDINGS
from razer.storage.file_names import INSTANCES as INSTANCES
from razer.storage.file_names import MESH_PLY as MESH_PLY
from razer.storage.file_names import PARTS as PARTS
from razer.storage.file_names import VOXELS as VOXELS

RGBD_CALIBRATION = "rgbd_calibration.json"
TRAJECTORY = "trajectory.txt"
GIVEN_TRAJECTORY = "given_trajectory.txt"  # where trajectory.txt is that, corrected
POSE_COVARIANCES = "pose_covariances.npz"
MESH_GLB = "mesh.glb"
TIMINGS = "timings.json"
CAMERA = "camera.json"
WORLD = "world.json"
TIMELINE = "timeline.rrd"
TIMELINE_PARTS = "timeline.*.rrd"  # until the run is finished
PANOPTIC_PLY = "panoptic.ply"
PANOPTIC = "panoptic.json"
SCENE_GRAPH = "scene_graph.json"
METRICS = "metrics.json"


class RunFolder:
    """A run folder in the making; as a context it vanishes on leaving unless `commit` was called, or it holds a
    checkpoint, from which the run can be resumed. One process at a time makes it.

    Raises BadInput if `final` cannot become a run folder: it exists and `overwrite` is false, it is
    something else than a run folder, another process makes it, or its place cannot be written to.
    """

    def __init__(self, final: Path, *, overwrite: bool = False) -> None:
        self.final = Path(os.path.abspath(final))
        self._overwrite = overwrite
        self._lock = FolderLock(self.final)
        self._check()
        require_writable(self.final)
        self._token = secrets.token_hex(4)
        self.partial = self.final.with_name(f".{self.final.name}.partial-{self._token}")
        self._created_parents: list[Path] = []
        self.checkpoint: Checkpoint | None = None
        """What the run goes on from."""

    @classmethod
    def unfinished(cls, final: Path) -> RunFolder:
        """That of a run that was cut off, with its newest checkpoint; raises BadInput where there is none, or where the
        place is taken: by a run that was made since, or one that was to be replaced."""
        folder = cls(final, overwrite=True)
        found = [(path, read_checkpoint(path / CHECKPOINT)) for path in folder.leftovers()]
        resumable = [(path, checkpoint) for path, checkpoint in found if checkpoint is not None]
        if not resumable:
            why = "the run there is complete" if (final / INSTANCES).exists() else "no run to it was cut off"
            raise BadInput(f"{final}: nothing to resume, as {why} after its first checkpoint")
        if os.path.lexists(final):
            raise BadInput(f"{final} is there already: move it away, and --resume makes it from the unfinished run")
        folder._overwrite = False  # what comes to the place meanwhile is not replaced
        folder.partial, folder.checkpoint = max(resumable, key=lambda one: (one[0] / CHECKPOINT).stat().st_mtime)
        return folder

    @property
    def checkpoints(self) -> Path:
        """Where checkpoints go."""
        return self.partial / CHECKPOINT

    @property
    def is_resumable(self) -> bool:
        """Whether it holds a checkpoint, and is not finished."""
        return (self.checkpoints / CHECKPOINT_FILE).exists()

    def _check(self) -> None:
        if not self.final.name:
            raise BadInput(f"{self.final} cannot be a run folder; choose another with -o")
        self._lock.require_free()
        if not os.path.lexists(self.final):
            return
        if not self._overwrite:
            raise BadInput(f"{self.final} exists; choose another folder with -o, or add --overwrite")
        if self.final.is_symlink() or not self.final.is_dir():
            raise BadInput(f"{self.final} is not a folder, so it is not overwritten; choose another with -o")
        if any(self.final.iterdir()) and not (self.final / INSTANCES).exists():
            raise BadInput(f"{self.final} is no run folder (no {INSTANCES}), so it is not overwritten; choose another")

    def leftovers(self) -> list[Path]:
        """Unfinished folders that killed runs to the same place left behind."""
        pattern = f".{self.final.name}.partial-*"
        return [path for path in sorted(self.final.parent.glob(pattern)) if path != self.partial]

    def __enter__(self) -> RunFolder:
        try:
            self._make_parents()
            self._lock.__enter__()
            if self.checkpoint is None:
                self.partial.mkdir()
            else:
                self._require_unfinished()
        except OSError as error:
            self._leave()
            raise BadInput(f"{self.final} cannot be written ({error.strerror}); choose another with -o") from error
        except BadInput:
            self._leave()
            raise
        return self

    def _make_parents(self) -> None:
        missing = [parent for parent in self.final.parents if not parent.exists()]
        for parent in reversed(missing):
            parent.mkdir()
            self._created_parents.append(parent)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.partial.exists() and not self.is_resumable:
            shutil.rmtree(self.partial, ignore_errors=True)
        self._leave()

    def write(self, name: str, writer: Callable[[Path], None]) -> None:
        """Write one file under a temporary name with the same ending, then rename it."""
        replace_file(self.partial / name, writer)

    def commit(self) -> Path:
        """Give the folder its final name, in place of an older run if there is one; returns that name. Raises BadInput
        where something else has come there meanwhile, and says where the run is then."""
        try:
            self._check()
        except BadInput as error:
            raise BadInput(f"{error}; the finished run is in {self._finish_as(self._free_place())}") from None
        if not self.final.exists():
            return self._finish_as(self.final)
        old = self.final.with_name(f".{self.final.name}.old-{self._token}")
        self.final.rename(old)
        self._finish_as(self.final)
        shutil.rmtree(old)
        return self.final

    def _free_place(self) -> Path:
        """The final place, with the first number behind its name that nothing has yet."""
        numbered = (self.final.with_name(f"{self.final.name}.{n}") for n in count(1))
        return next(path for path in numbered if not os.path.lexists(path))

    def _require_unfinished(self) -> None:
        """Leave of an unfinished run what it is resumed from: others of its files may be half-written."""
        if not self.is_resumable:
            raise BadInput(f"{self.partial} is gone: the run was resumed elsewhere, or removed")
        kept = {CHECKPOINT, CONFIG, *(path.name for path in self.partial.glob(TIMELINE_PARTS))}
        for path in self.partial.iterdir():
            if path.name not in kept:
                path.unlink()

    def _finish_as(self, place: Path) -> Path:
        """Give the folder a name; a kill before that can be resumed, and one after it leaves no more than is needed."""
        self.partial.rename(place)
        shutil.rmtree(place / CHECKPOINT, ignore_errors=True)
        for part in place.glob(TIMELINE_PARTS):
            part.unlink()
        return place

    def _leave(self) -> None:
        """Give the lock back, and remove parents that were made for nothing."""
        self._lock.__exit__(None, None, None)
        for parent in reversed(self._created_parents):
            with suppress(OSError):  # something is in it
                parent.rmdir()
