"""Edits as they are asked for and logged: what is changed of which instances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from razer.edits.region import Region
from razer.errors import BadInput

MAX_NAME = 80  # characters
MAX_MERGED = 1000
Id = Annotated[int, Field(ge=1, lt=2**31, strict=True)]


def _printable(text: str) -> str:
    """Names reach terminals and pages: one line, nothing that either obeys."""
    stripped = " ".join(text.split())
    if not stripped or not stripped.isprintable():
        raise ValueError("a name is some printable characters")
    return stripped


def _distinct(instances: list[int]) -> list[int]:
    if len(set(instances)) < len(instances):
        raise ValueError("each instance is named once")
    return instances


Name = Annotated[str, Field(max_length=MAX_NAME), AfterValidator(_printable)]


class _Edit(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)
    ids: ClassVar[tuple[str, ...]] = ("instance",)  # the fields that name instances

    @property
    def touched(self) -> tuple[int, ...]:
        """The ids of the instances that it changes."""
        return tuple(getattr(self, name) for name in self.ids)

    def on(self, ids: Mapping[int, int]) -> Self:
        """The same of instances that have other ids, {own: other}."""
        return self.model_copy(update={name: ids[getattr(self, name)] for name in self.ids})

    def to_json(self) -> dict[str, Any]:
        """As it stands in the log."""
        return self.model_dump(by_alias=True, exclude_none=True)


class Rename(_Edit):
    """Another name for one instance; a thing stays a thing."""

    kind: Literal["rename"] = "rename"
    instance: Id
    name: Name


class Relabel(_Edit):
    """Another class for one instance, which says whether it is stuff, too."""

    kind: Literal["relabel"] = "relabel"
    instance: Id
    class_name: Annotated[Name, Field(alias="class")]


class Merge(_Edit):
    """The first instance takes in the others, which are no more."""

    kind: Literal["merge"] = "merge"
    instances: Annotated[list[Id], Field(min_length=2, max_length=MAX_MERGED), AfterValidator(_distinct)]

    @property
    def touched(self) -> tuple[int, ...]:
        """The ids of the instances that it changes."""
        return tuple(self.instances)

    def on(self, ids: Mapping[int, int]) -> Self:
        """The same of instances that have other ids, {own: other}, some of which may be one by now."""
        return self.model_copy(update={"instances": list(dict.fromkeys(ids[i] for i in self.instances))})


class Delete(_Edit):
    """An instance is no more, and its surface nobody's."""

    kind: Literal["delete"] = "delete"
    instance: Id


class Split(_Edit):
    """What of an instance lies in a region becomes an instance of its own, `new`, which the log gives its id."""

    kind: Literal["split"] = "split"
    instance: Id
    region: Region
    new: Id | None = None


class MoveBorder(_Edit):
    """What of one instance lies in a region becomes another's."""

    ids: ClassVar[tuple[str, ...]] = ("source", "target")
    kind: Literal["move_border"] = "move_border"
    source: Annotated[Id, Field(alias="from")]
    target: Annotated[Id, Field(alias="to")]
    region: Region


Edit = Rename | Relabel | Merge | Delete | Split | MoveBorder
EDIT = TypeAdapter[Edit](Annotated[Edit, Field(discriminator="kind")])


def edit_of(content: Mapping[str, Any]) -> Edit:
    """An edit of its JSON; raises BadInput that says what is wrong with it."""
    try:
        return EDIT.validate_python(dict(content))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"][1:])
        problem = str(first["msg"]).removeprefix("Input ").removeprefix("Value error, ")
        raise BadInput(f"this is no edit: {f'{where}: ' if where else ''}{problem}") from error
