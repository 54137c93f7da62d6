"""RAZER: an RGB-D recording becomes a map of named, queryable instances.

The names below are the library's face; each is loaded when it is first used, so that `import razer` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from razer.config import MapperConfig as MapperConfig
    from razer.errors import BadInput as BadInput
    from razer.errors import RazerError as RazerError
    from razer.errors import UnusableFrame as UnusableFrame
    from razer.frame import Frame as Frame
    from razer.frame import Intrinsics as Intrinsics
    from razer.frame import Masks as Masks
    from razer.mapper import Mapper as Mapper
    from razer.models import make_embedder as make_embedder
    from razer.models import make_segmenter as make_segmenter
    from razer.panoptic_map import PanopticMap as PanopticMap
    from razer.saved_map import load_map as load_map

    __version__: str

_HOME = {
    "BadInput": "razer.errors",
    "Frame": "razer.frame",
    "Intrinsics": "razer.frame",
    "Mapper": "razer.mapper",
    "MapperConfig": "razer.config",
    "Masks": "razer.frame",
    "PanopticMap": "razer.panoptic_map",
    "RazerError": "razer.errors",
    "UnusableFrame": "razer.errors",
    "load_map": "razer.saved_map",
    "make_embedder": "razer.models",
    "make_segmenter": "razer.models",
}
__all__ = sorted([*_HOME, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("razer")
        except PackageNotFoundError:  # a checkout that is not installed
            return "0+unknown"
    if name not in _HOME:
        raise AttributeError(f"module 'razer' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
