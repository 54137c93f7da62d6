"""Resident memory of this process."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import psutil

_STATUS = Path("/proc/self/status")


def rss_mb() -> float:
    """Resident memory now, in units of 10^6 bytes."""
    return psutil.Process().memory_info().rss / 1e6


def peak_rss_mb() -> float:
    """The most resident memory this process has had, in units of 10^6 bytes.

    getrusage starts from the parent's peak on Linux, so the kernel's own high-water mark is preferred.
    """
    if _STATUS.exists():
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024 / 1e6
    unit_bytes = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit_bytes / 1e6
