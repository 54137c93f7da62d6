"""Transfers that are tried again: connections break where no answer of the store tells its library to."""

from __future__ import annotations

import random
from collections.abc import Callable
from time import sleep
from typing import TypeVar

from razer.errors import BadInput

T = TypeVar("T")
_ATTEMPTS, _FIRST_WAIT_S, _LONGEST_WAIT_S = 7, 0.3, 20.0
_FINAL = (FileNotFoundError, PermissionError, NotADirectoryError, IsADirectoryError, BadInput)


def persistently(action: Callable[[], T], what: str) -> T:
    """What the action returns, tried seven times with growing waits; raises BadInput, which says what could not be
    done, at once where waiting would not help."""
    for attempt in range(_ATTEMPTS):
        try:
            return action()
        except BadInput:
            raise
        except Exception as error:  # each store's library has its own
            if isinstance(error, _FINAL) or _is_final(error) or attempt == _ATTEMPTS - 1:
                raise BadInput(f"{what}: {_described(error)}") from error
        sleep(random.uniform(0.5, 1.0) * min(_FIRST_WAIT_S * 2**attempt, _LONGEST_WAIT_S))
    raise AssertionError


def _is_final(error: Exception) -> bool:
    return type(error).__name__ in ("NoCredentialsError", "PartialCredentialsError", "ParamValidationError")


def _described(error: Exception) -> str:
    return str(error) or type(error).__name__
