"""Remap table of instance ids: each lives, was fused into another, or was pruned."""

from __future__ import annotations

import torch
from torch import Tensor


class InstanceIdMap:
    """For each id ever assigned the id that stands for it now, 0 = nobody; several volumes may read one table."""

    def __init__(self, device: torch.device) -> None:
        self._of = torch.zeros(1, dtype=torch.int32, device=device)  # longer than there are ids, to grow seldom
        self.newest_id = 0
        """The largest id admitted so far."""

    def admit(self, track_id: int) -> None:
        """Make a new id known; ids must be admitted in increasing order before they get votes."""
        if track_id >= len(self._of):
            more = torch.arange(len(self._of), 2 * track_id + 1, dtype=torch.int32, device=self._of.device)
            self._of = torch.cat([self._of, more])
        self.newest_id = max(self.newest_id, track_id)

    def replace(self, gone: int, survivor: int) -> None:
        """All that was `gone` is `survivor` from now on; survivor 0 forgets it."""
        self._of[self._of == gone] = survivor

    def resolve(self, ids: Tensor) -> Tensor:
        """Ids (any shape) after all fusions and prunings so far, int32."""
        return self._of.index_select(0, ids.to(self._of.device).flatten()).view(ids.shape)


def numbered(ids: Tensor, newest_id: int) -> tuple[Tensor, Tensor]:
    """The ids (M,) that occur among some (any shape), in order, and which of them each is: counts over them stay small
    however many ids were ever given."""
    occurs = torch.zeros(newest_id + 1, dtype=torch.bool, device=ids.device)
    occurs[ids.long()] = True
    known = torch.nonzero(occurs).squeeze(1)
    number = torch.zeros(newest_id + 1, dtype=torch.int64, device=ids.device)
    number[known] = torch.arange(len(known), device=ids.device)
    return known, number[ids.long()]
