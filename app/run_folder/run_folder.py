"""The folder of one run: written beside its final place, and moved there when it is complete."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

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
POSE_COVARIANCES = "pose_covariances.npz"
MESH_GLB = "mesh.glb"
TIMINGS = "timings.json"
CAMERA = "camera.json"
TIMELINE = "timeline.rrd"
PANOPTIC_PLY = "panoptic.ply"
PANOPTIC = "panoptic.json"
SCENE_GRAPH = "scene_graph.json"
METRICS = "metrics.json"


class RunFolder:
    """A run folder in the making; as a context it vanishes on leaving unless `commit` was called.

    Raises BadInput if `final` cannot become a run folder: it exists and `overwrite` is false, it is
    something else than a run folder, or its place cannot be written to.
    """

    def __init__(self, final: Path, *, overwrite: bool = False) -> None:
        self.final = Path(os.path.abspath(final))
        self._overwrite = overwrite
        self._check()
        self._token = secrets.token_hex(4)
        self.partial = self.final.with_name(f".{self.final.name}.partial-{self._token}")
        self._created_parents: list[Path] = []

    def _check(self) -> None:
        if not self.final.name:
            raise BadInput(f"{self.final} cannot be a run folder; choose another with -o")
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
        missing = [parent for parent in self.final.parents if not parent.exists()]
        try:
            for parent in reversed(missing):
                parent.mkdir()
                self._created_parents.append(parent)
            self.partial.mkdir()
        except OSError as error:
            self._discard()
            raise BadInput(
                f"{self.final} cannot be written ({error.strerror}); choose another folder with -o"
            ) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.partial.exists():
            self._discard()

    def write(self, name: str, writer: Callable[[Path], None]) -> None:
        """Write one file under a temporary name with the same ending, then rename it."""
        replace_file(self.partial / name, writer)

    def commit(self) -> Path:
        """Give the folder its final name, in place of an older run if there is one; returns that name."""
        self._check()  # another run may have finished there meanwhile
        if not self.final.exists():
            self.partial.rename(self.final)
            return self.final
        old = self.final.with_name(f".{self.final.name}.old-{self._token}")
        self.final.rename(old)
        self.partial.rename(self.final)
        shutil.rmtree(old)
        return self.final

    def _discard(self) -> None:
        shutil.rmtree(self.partial, ignore_errors=True)
        for parent in reversed(self._created_parents):
            parent.rmdir()
