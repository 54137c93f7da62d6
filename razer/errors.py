"""Errors that users cause and can mend. Imports nothing, so that anything may import it."""

from __future__ import annotations

_MAX_CHARACTERS = 2000


class RazerError(ValueError):
    """Anything this project says in one plain line instead of a traceback."""

    def __str__(self) -> str:
        """The message as one line that a terminal can show, whatever names of files and values it quotes: line ends and
        control characters become escapes, and the middle of what is very long is left out."""
        text = super().__str__()
        if not text.isprintable():
            text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
        half = _MAX_CHARACTERS // 2
        return text if len(text) <= _MAX_CHARACTERS else f"{text[:half]} ... {text[-half:]}"


class BadInput(RazerError):
    """Input that cannot be used; the message is one plain line that names the thing and the fix."""


class UntrustedPlugin(BadInput):
    """Code from outside that data names; it is not loaded."""


class EditConflict(BadInput):
    """An edit that somebody else's was faster than; the message says whose and what it did."""


class UnusableFrame(BadInput):
    """One frame that cannot be used; the message says why. The rest of the sequence may be fine."""


def one_line(error: BaseException) -> str:
    """The first line of what a library says, or the error's kind where it says nothing."""
    return (str(error).splitlines() or [type(error).__name__])[0]
