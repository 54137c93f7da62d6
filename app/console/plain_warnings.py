"""Warnings of libraries and of the method as one line each."""

from __future__ import annotations

import warnings

from app.console.printable import printable


def warn_in_one_line() -> None:
    """Have warnings of this process printed as one line each, without the line of code that gave them."""
    warnings.formatwarning = lambda message, *_, **__: f"WARNING: {printable(' '.join(str(message).split()))}\n"
