"""What a library says of a model it cannot use, short enough for a message of ours."""

from __future__ import annotations


def one_line(error: Exception) -> str:
    """The first line of an error, or its kind where it says nothing."""
    return (str(error).splitlines() or [type(error).__name__])[0]
