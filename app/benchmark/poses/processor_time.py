"""Processor time of pose estimation, beside that of plain TSDF fusion of the same frames in the same process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import process_time
from typing import TypeVar

import numpy as np

from app.benchmark.plain_fusion import PlainFusion
from app.profiling.map_device import MapDevice
from razer.arrays import Pose
from razer.config import VoxelSettings
from razer.frame import Frame

PERCENTILE = 95
N_BLOCKS = 4000  # of 16³ voxels, which most walks stay below
T = TypeVar("T")


@dataclass
class ProcessorTime:
    """Seconds of processor, threads added up, of each frame, of the end of the estimation, and of plain fusion of each
    frame that shows something, at its true pose."""

    frames_s: list[float] = field(default_factory=list)
    end_s: float = 0.0
    plain_ms: list[float] = field(default_factory=list)
    _plain: PlainFusion = field(
        default_factory=lambda: PlainFusion(VoxelSettings(), N_BLOCKS, MapDevice(), process_time)
    )

    def of_frame(self, work: Callable[[], T]) -> T:
        """Do what a frame takes."""
        started_s = process_time()
        result = work()
        self.frames_s.append(process_time() - started_s)
        return result

    def of_end(self, work: Callable[[], T]) -> T:
        """Do what the end takes."""
        started_s = process_time()
        result = work()
        self.end_s += process_time() - started_s
        return result

    def fuse(self, frame: Frame, world_from_camera: Pose) -> None:
        """Fuse a frame plainly."""
        self.plain_ms.append(self._plain.fuse_ms(replace(frame, world_from_camera=world_from_camera)))

    def figures(self) -> dict[str, float]:
        """Figures of a walk.

        Returns:
            `cpu_ms` for each frame that shows something, the end included; how many times plain fusion's that is
            (`to_plain`); how many times its median a frame takes in 95 of 100 cases (`p95_to_plain`); which share of
            all is the end's (`end_share`).
        """
        total_s, n_seeing = sum(self.frames_s) + self.end_s, max(len(self.plain_ms), 1)
        mean_ms, median_ms = (float(f(self.plain_ms or [0.0])) for f in (np.mean, np.median))
        p95_ms = 1000 * float(np.percentile(self.frames_s or [0.0], PERCENTILE))
        return {
            "cpu_ms": round(1000 * total_s / n_seeing, 1),
            "to_plain": round(1000 * total_s / n_seeing / max(mean_ms, 1e-9), 2),
            "p95_to_plain": round(p95_ms / max(median_ms, 1e-9), 2),
            "end_share": round(self.end_s / max(total_s, 1e-9), 3),
        }
