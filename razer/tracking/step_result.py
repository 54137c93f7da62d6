"""Result of one step: candidates, decisions, and what was fused and pruned, for viewers and reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from razer.arrays import Int32Array
from razer.detection.lifting import Detection

Outcome = Literal["matched", "joined", "born"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A track a detection might belong to: geometric distance V_ij, semantic distance S_ij, cost M_ij (RAZER eq. 8)."""

    track_id: int
    geometry: float
    semantic: float
    cost: float


@dataclass(frozen=True, slots=True)
class Decision:
    """The track of a detection and why: matched by the assignment, joined as a further part, or born as new; and the
    tracks whose voxels it takes none of, which its mask covers though more views hold them apart from it."""

    detection: int
    candidates: tuple[Candidate, ...]
    gate: float
    outcome: Outcome
    track_id: int
    spares: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class StepResult:
    """One mapped frame: id_image (H, W) int32 track per pixel, 0 = nobody; fused as (gone, survivor);
    changed_blocks (M, 3) int32 keys of the blocks that were fused into; rebuilt, whether the whole map was replaced
    by one that follows corrected poses."""

    frame_index: int
    id_image: Int32Array
    detections: tuple[Detection, ...]
    decisions: tuple[Decision, ...]
    fused: tuple[tuple[int, int], ...]
    pruned: tuple[int, ...]
    changed_blocks: Int32Array
    rebuilt: bool = False

    @property
    def owners(self) -> Int32Array:
        """The track (N,) of each detection."""
        return np.array([d.track_id for d in self.decisions], np.int32)

    @property
    def born(self) -> tuple[int, ...]:
        """Ids of the tracks that started in this frame."""
        return tuple(d.track_id for d in self.decisions if d.outcome == "born")
