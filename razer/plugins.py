"""Plug-ins by name: a table of the parts that ship, and `module:Class` from outside where that is trusted.

A name is code: "os:system" is as good a `module:Class` as any. So names that come with data (a run folder's
config.toml, a --config file) choose among the parts that ship, and outside code is loaded only where the one who
started the program named it. A program that calls this library passes the object itself.
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Self

from pydantic import Field, PrivateAttr, TypeAdapter, ValidationError

from razer.errors import BadInput, UntrustedPlugin, one_line
from razer.settings import Settings, problem_of


@dataclass(frozen=True)
class Trust:
    """Which outside code may be loaded: that of the given names, or everything."""

    names: frozenset[str] = frozenset()
    everything: bool = False

    def covers(self, name: str) -> bool:
        """Whether code may be loaded under this name."""
        return self.everything or name in self.names

    def also(self, names: Sequence[str]) -> Trust:
        """This trust, and that in more names; of a combination, "a:B+label=c:D", in each of its parts."""
        parts = {part.rpartition("=")[2].strip() for name in names for part in name.split("+")}
        return Trust(self.names | frozenset(names) | parts, self.everything)


NO_TRUST = Trust()
FULL_TRUST = Trust(everything=True)
# A part may be made of parts that its options name: they are trusted as far as it is.
_inherited: ContextVar[Trust] = ContextVar("trust", default=NO_TRUST)


def load(
    kind: str,
    name: str,
    table: Mapping[str, str],
    options: Mapping[str, Any],
    *,
    methods: Sequence[str] = (),
    trust: Trust | None = None,
) -> Any:
    """Build a part by name.

    Args:
        kind: what it is, for messages: segmenter, embedder, reader.
        name: a key of `table`, or "module:Class".
        table: name -> "module:Class" of the parts that ship.
        options: its named arguments.
        methods: what its class must have; none: any function will do.
        trust: which outside code may be loaded; None = as far as the part goes that is being built, else none.

    Raises:
        BadInput: for an unknown name, one that is not trusted, and options that the part does not take.
    """
    trust = _inherited.get() if trust is None else trust
    make = _part(kind, name, table, methods, trust)
    _check_options(f"{kind} '{name}'", make, options)
    try:
        with _trusting(trust):
            part = make(**options)
    except TypeError as error:
        problem = _wrong_value(make, options) or _about_options(error)
        raise BadInput(f"{kind} '{name}' does not take these options: {problem}") from error
    except OSError as error:
        raise BadInput(f"{kind} '{name}' cannot be made: {one_line(error)}") from error
    if problem := _wrong_value(make, options):  # last: what a part itself says of its options is clearer
        raise BadInput(f"{kind} '{name}' does not take these options: {problem}")
    return part


def _check_options(part: str, make: Callable[..., Any], options: Mapping[str, Any]) -> None:
    """Raise BadInput for options that a part does not have, and for those that it lacks."""
    try:
        parameters = inspect.signature(make).parameters.values()
    except (TypeError, ValueError):  # of some built-in classes nobody knows them
        return
    known = {each.name: each for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)}
    takes_any = any(each.kind is each.VAR_KEYWORD for each in parameters)
    for option in options:
        if option not in known and not takes_any:
            has = f"its options are {', '.join(known)}" if known else "it has none"
            raise BadInput(f"{part} does not take these options: there is no '{option}', {has}")
    lacking = [f"'{name}'" for name, each in known.items() if each.default is each.empty and name not in options]
    if lacking:
        these = f"{len(lacking)} option{'s' if len(lacking) > 1 else ''}"
        raise BadInput(f"{part} does not take these options: missing {these}: {' and '.join(lacking)}")


def _wrong_value(make: Callable[..., Any], options: Mapping[str, Any]) -> str:
    """The first option whose value is of another kind than the part asks for, and what it should be; else ""."""
    try:
        parameters = inspect.signature(make).parameters
    except (TypeError, ValueError):
        return ""
    for option, value in options.items():
        if option in parameters and (problem := _problem(make, parameters[option].annotation, value)):
            return f"{option} = {value!r} {problem}"
    return ""


def _problem(make: Callable[..., Any], annotation: Any, value: Any) -> str:
    """Why a value that a file or the command line can give is not what an annotation asks for, "" where it may be."""
    if type(value) not in (str, int, float, bool, list, dict):
        return ""
    try:
        module = vars(importlib.import_module(make.__module__))
        checked = TypeAdapter(eval(annotation, module) if isinstance(annotation, str) else annotation)
    except Exception:  # what a class of its own asks for is its own affair
        return ""
    try:
        taken = checked.validate_python(value)
    except ValidationError as error:
        return problem_of(error)
    is_number_of_text = isinstance(value, str) and isinstance(taken, int | float)
    return "should be a number" if is_number_of_text else ""


def _about_options(error: TypeError) -> str:
    """What is wrong with the options, without the names of the code that says so."""
    return re.sub(r"^[\w.]+\(\) ", "", one_line(error)).replace("required positional argument", "option")


def _part(kind: str, name: str, table: Mapping[str, str], methods: Sequence[str], trust: Trust) -> Callable[..., Any]:
    module_name, separator, class_name = table.get(name, name).partition(":")
    if not separator:
        raise BadInput(f"unknown {kind} '{name}': choose one of {', '.join(sorted(table))}, or module:Class")
    if name not in table and not trust.covers(name):
        raise UntrustedPlugin(
            f"{kind} '{name}' is code from outside, named by data: it is not loaded. If you know it, name it on the "
            f"command line yourself or add --trust-plugins (from Python: pass the object)"
        )
    try:
        part: Callable[..., Any] = getattr(importlib.import_module(module_name), class_name)
    except (ImportError, AttributeError, ValueError, TypeError) as error:
        raise BadInput(f"{kind} '{name}' cannot be loaded: {error}") from error
    if methods and not (isinstance(part, type) and all(callable(getattr(part, each, None)) for each in methods)):
        raise BadInput(f"{kind} '{name}' is no class with the method {' and '.join(methods)}")
    return part


@contextmanager
def _trusting(trust: Trust) -> Iterator[None]:
    token = _inherited.set(trust)
    try:
        yield
    finally:
        _inherited.reset(token)


class PluginSettings(Settings):
    """A section that names a part. Which outside code it may name is said by whoever runs the program, never by a
    file: it is no setting."""

    _trust: Trust = PrivateAttr(default=NO_TRUST)

    @property
    def trust(self) -> Trust:
        """Which outside code may be loaded."""
        return self._trust

    def with_trust(self, trust: Trust) -> Self:
        """The same settings with more trust."""
        copy = self.model_copy()
        copy._trust = trust
        return copy

    def __eq__(self, other: object) -> bool:
        """Whether the settings are the same; trust is none of them."""
        return isinstance(other, type(self)) and self.model_dump() == other.model_dump()


AUTO = "auto"
_ASKED = "What was asked for, as a run records it where that was 'auto'. Has no effect on a new run."


class SegmenterSettings(PluginSettings):
    """What finds masks."""

    name: str = Field(
        AUTO,
        description="auto takes the models that are here, else geometric; geometric, yolo, rfdetr, semantic, sam, "
        "prompted, panoptic, oracle, masks, or an outside module:Class; several joined by +, as in yolo+semantic.",
    )
    options: dict[str, Any] = Field(
        {}, description="Its named arguments, such as noise = 'full'; of several those of each by its name."
    )
    asked: str | None = Field(None, description=_ASKED)


class EmbedderSettings(PluginSettings):
    """What describes masks by vectors."""

    name: str = Field(
        AUTO,
        description="auto takes a model of words that is here, else appearance; appearance, clip, names, oracle, or an "
        "outside module:Class.",
    )
    options: dict[str, Any] = Field({}, description="Its named arguments.")
    asked: str | None = Field(None, description=_ASKED)
