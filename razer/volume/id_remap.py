"""Remap table of instance ids: each lives, was fused into another, or was pruned."""

from __future__ import annotations

import torch
from torch import Tensor


class InstanceIdMap:
    """For each id ever assigned the id that stands for it now, 0 = nobody; several volumes may read one table."""

    def __init__(self, device: torch.device) -> None:
        self._of = torch.zeros(1, dtype=torch.int32, device=device)

    @property
    def newest_id(self) -> int:
        """The largest id admitted so far."""
        return len(self._of) - 1

    def admit(self, track_id: int) -> None:
        """Make a new id known; ids must be admitted in increasing order before they get votes."""
        missing = torch.arange(len(self._of), track_id + 1, dtype=torch.int32, device=self._of.device)
        self._of = torch.cat([self._of, missing])

    def replace(self, gone: int, survivor: int) -> None:
        """All that was `gone` is `survivor` from now on; survivor 0 forgets it."""
        self._of[self._of == gone] = survivor

    def resolve(self, ids: Tensor) -> Tensor:
        """Ids (any shape) after all fusions and prunings so far, int32."""
        return self._of[ids.long()]
