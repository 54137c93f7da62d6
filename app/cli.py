"""The command line; verbs are imported when they are used, so that `razer --help` is instant."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata
from threading import current_thread, main_thread
from typing import NoReturn

from cyclopts import App, CycloptsError, Group, Parameter

from app.console.leaving import EndAtOnce
from app.console.no_room import no_room_line
from app.console.plain_warnings import warn_in_one_line
from app.console.signals import raise_signals
from app.console.streams import QUIET
from app.console.typed_values import typed_value
from app.console.usage import usage_text
from app.verbs import MODEL_VERBS, VERBS
from razer.errors import BadInput

BAD_INPUT, INTERRUPTED = 2, 130
_NAMES = {verb.name for verbs in VERBS.values() for verb in verbs} | {"models"}

app = App(
    name="razer",
    help="RGB-D recordings become 3D panoptic maps that know what is where.",
    help_format="markdown",
    help_epilogue="--quiet: no progress and no notes on standard error. `razer VERB --help` has examples.",
    version=lambda: metadata.version("razer"),
    group_commands=Group("Options", sort_key=99),
    default_parameter=Parameter(converter=typed_value),
    suppress_keyboard_interrupt=False,  # it would end the program without a word
)


def _add_verbs(app: App) -> None:
    for place, (purpose, verbs) in enumerate(VERBS.items()):
        group = Group(purpose, sort_key=place)
        for order, verb in enumerate(verbs):
            app.command(
                f"app.commands.{verb.target}",
                name=verb.name,
                help=verb.about,
                group=group,
                sort_key=order,
                **({} if verb.is_app else {"help_epilogue": verb.epilogue}),
            )
    models = App(name="models", help="List and download 2D models.", help_format="markdown", group=group, sort_key=9)
    for function, (name, about) in MODEL_VERBS.items():
        models.command(f"app.commands.prepare.models:{function}", name=name, help=about)
    app.command(models)


_add_verbs(app)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run one command and exit: 0 done, 2 unusable input or usage, or no room for it on disk or in memory (one plain
    line), 130 interrupted, 143 told to end."""
    if current_thread() is main_thread():
        raise_signals()
    # What lies in the working directory is data: helper processes must not import it as modules.
    os.environ["PYTHONSAFEPATH"] = "1"
    warn_in_one_line()
    tokens = [*(sys.argv[1:] if arguments is None else arguments)]
    try:
        with _quiet_if_asked(tokens) as heard:
            code = app(heard, exit_on_error=False, print_error=False, result_action="return_value")
    except KeyboardInterrupt:
        print("razer: interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except CycloptsError as error:
        verb = next((token for token in tokens if token in _NAMES), None)
        asked = f"razer {verb}" if verb else "razer"
        print(f"{asked}: {_plain(usage_text(str(error)))} (see {asked} --help)", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except BadInput as error:
        print(f"razer: {_plain(str(error))}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except Exception as error:
        if (line := no_room_line(error)) is None:
            raise
        print(f"razer: {_plain(line)}", file=sys.stderr)
        raise EndAtOnce(BAD_INPUT) from None
    sys.exit(code or 0)


@contextmanager
def _quiet_if_asked(tokens: list[str]) -> Iterator[list[str]]:
    """The command without --quiet, which every verb knows; while it runs, consoles and helper processes know of it."""
    ended = tokens.index("--") if "--" in tokens else len(tokens)
    kept = [token for token in tokens[:ended] if token != "--quiet"]
    before = os.environ.get(QUIET, "")
    os.environ[QUIET] = "1" if len(kept) < ended else before
    try:
        yield kept + tokens[ended:]
    finally:
        os.environ[QUIET] = before


def _plain(message: str) -> str:
    """A message on one line, without characters that a terminal obeys: names from files are part of it."""
    return " ".join("".join(c if c.isprintable() else " " for c in message).split())
