"""Libraries that only some verbs need, and that an extra installs."""

from __future__ import annotations

from importlib.util import find_spec

from razer.errors import BadInput

_SERVING = ("fastapi", "uvicorn", "python_multipart", "PIL", "mcp")


def can_serve() -> bool:
    """Whether all libraries of the extra `serve` are installed."""
    return all(find_spec(name) is not None for name in _SERVING)


def require_serve() -> None:
    """Raise BadInput where a library of the extra `serve` is not installed."""
    if not can_serve():
        raise BadInput("serving a map needs more libraries: pip install 'razer[serve]'")


def require_s3() -> None:
    """Raise BadInput where the library of the extra `s3` is not installed."""
    if find_spec("s3fs") is None:
        raise BadInput("s3:// needs another library: pip install 'razer[s3]'")


def require_cluster() -> None:
    """Raise BadInput where the library of the extra `cluster` is not installed."""
    if find_spec("ray") is None:
        raise BadInput("a cluster needs another library: pip install 'razer[cluster]'")


def require_library() -> None:
    """Raise BadInput where a library of the extra `library` is not installed."""
    if find_spec("lancedb") is None:
        raise BadInput("a library of maps needs one more library: pip install 'razer[library]'")
