"""CPU cores of the mapping process, and those left to its helper processes."""

from __future__ import annotations

import os

HELPERS = 2  # processes beside it: one locates frames, one perceives them


def leave_cores_to_helpers() -> None:
    """Let Open3D's threads leave two cores free, unless OMP_NUM_THREADS says otherwise. To be called before Open3D is
    loaded. Threads that wait for a core that another process has cost more than they bring: 5 % of a run on two."""
    os.environ.setdefault("OMP_NUM_THREADS", str(max(1, (os.cpu_count() or 1) - HELPERS)))
