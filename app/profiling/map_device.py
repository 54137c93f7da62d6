"""Device of the voxel map, for who measures: when it is done, and what of its memory is taken."""

from __future__ import annotations

import torch


class MapDevice:
    """The device that voxels live on, by the `name` that Open3D has for it."""

    def __init__(self, name: str = "CPU:0") -> None:
        self.name = name
        self.is_cuda = name.upper().startswith("CUDA")

    def wait(self) -> None:
        """Return when all work that was handed to the device is done: on CUDA a call returns before that. Open3D and
        torch both use the one default stream."""
        if self.is_cuda:
            torch.cuda.synchronize()

    def used_mb(self) -> float:
        """Memory of a CUDA device that programs have taken, in units of 10^6 bytes; 0 on the CPU, where it is that of
        the process."""
        if not self.is_cuda:
            return 0.0
        free, total = torch.cuda.mem_get_info()
        return (total - free) / 1e6
