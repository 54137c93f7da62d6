"""Values on the command line: whole numbers are digits, and a path is never empty."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

from cyclopts import Token, convert

_WHOLE_NUMBER = re.compile(r"[-+]?[0-9]{1,18}")


def typed_value(kind: Any, tokens: Sequence[Token]) -> Any:
    """What words of the command line mean as a value of some kind. Raises ValueError for a whole number that has a
    fraction, and would be rounded, that is written in another way than in digits, or has more of them than count
    anything; and for an empty path, such as a shell makes of a variable that is not set."""
    kinds = {kind, *get_args(kind)}
    for token in tokens:
        if int in kinds and not _WHOLE_NUMBER.fullmatch(token.value):
            raise ValueError(f'"{token.value}" should be a whole number.')
        if Path in kinds and not token.value:
            raise ValueError("a path is empty: give a file or a folder.")
    return convert(kind, tokens)
