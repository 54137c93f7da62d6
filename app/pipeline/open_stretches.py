"""Stretches of a path along which a direction stayed open, said in words."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from slam.report import OpenStretch

_MAX_STRETCHES = 3


def print_open(stretches: Sequence[OpenStretch], console: Console) -> None:
    """Where nothing that was seen says how the camera moved in some direction."""
    for stretch in stretches[:_MAX_STRETCHES]:
        console.print(f"  {stretch.describe()}", soft_wrap=True, highlight=False)
    if len(stretches) > _MAX_STRETCHES:
        console.print(f"  and {len(stretches) - _MAX_STRETCHES} more times")
