"""Observations of a walk on disk: perceived once for all variants that share it, mapped by one variant after the other,
so that memory holds one map."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from razer.config import MapperConfig
from razer.detection.perception import Observation, Perception
from razer.frame import Frame
from razer.models import Embedder, Segmenter


class ObservationFile:
    """Observations in a file, in the order of their frames; may be read many times."""

    def __init__(self, path: Path, observations: Iterable[Observation]) -> None:
        """Write them, over what was there before."""
        self.path = path
        with path.open("wb") as file:
            for observation in observations:
                pickle.dump(observation, file, pickle.HIGHEST_PROTOCOL)

    def __iter__(self) -> Iterator[Observation]:
        with self.path.open("rb") as file:
            while observation := _next(file):
                yield observation


class PerceivedWalk:
    """A walk as it is perceived under settings that most variants share, and under others."""

    def __init__(self, folder: Path, models: tuple[Segmenter, Embedder], base: MapperConfig) -> None:
        """No frames; `folder` holds files that take some 5 MB a frame, `base` are settings that many share."""
        self._folder = folder
        self._models = models
        self._base = base
        self._default: ObservationFile | None = None

    def record(self, frames: Iterable[Frame]) -> None:
        """Perceive and keep the frames of the walk."""
        perception = Perception(self._base, *self._models)
        self._default = ObservationFile(self._folder / "default", map(perception.observe, frames))

    def perceived(self, config: MapperConfig) -> ObservationFile:
        """The walk under these settings; valid until it is next asked for. Raises ValueError before `record`."""
        if self._default is None:
            raise ValueError("no walk was recorded")
        if _perception_settings(config) == _perception_settings(self._base):
            return self._default
        perception = Perception(config, *self._models)
        return ObservationFile(self._folder / "other", (perception.observe(o.frame) for o in self._default))


def _perception_settings(config: MapperConfig) -> tuple[object, ...]:
    """All settings that `Perception.observe` reads."""
    voxels = config.voxels
    return (
        config.masks,
        config.lifting,
        voxels.voxel_size_m,
        voxels.depth_min_m,
        voxels.depth_max_m,
        voxels.truncation_m,
    )


def _next(file: BinaryIO) -> Observation | None:
    try:
        observation: Observation = pickle.load(file)
    except EOFError:
        return None
    return observation
