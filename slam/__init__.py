"""Where the camera was: odometry, loop closure and smoothing. The names below are loaded when they are first used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from slam.poses import GivenPoses as GivenPoses
    from slam.system import SlamSystem as SlamSystem

_HOME = {"GivenPoses": "slam.poses", "SlamSystem": "slam.system"}
__all__ = ["GivenPoses", "SlamSystem"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'slam' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
