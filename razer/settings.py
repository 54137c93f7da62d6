"""The base of all settings: frozen, checked, unknown names refused."""

from __future__ import annotations

from typing import get_args

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

# Kinds of errors by how their names begin, in words of those who write settings and not of those who check them.
_SHOULD_BE = {
    "int": "a whole number",
    "float": "a number",
    "finite_number": "a finite number",
    "bool": "true or false",
    "string": "a text",
    "path": "a text",
    "tuple": "a list",
    "list": "a list",
    "dict": "a section of names and values",
    "model": "a section: set its keys one by one",
}


class Settings(BaseModel):
    """A frozen group of settings; unknown names are refused and ranges are checked."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @field_validator("*", mode="before")
    @classmethod
    def _true_is_no_number(cls, value: object, info: ValidationInfo) -> object:
        kind = cls.model_fields[str(info.field_name)].annotation
        kinds = {kind, *get_args(kind)}
        if isinstance(value, bool) and kinds & {int, float} and bool not in kinds:
            raise PydanticCustomError("float_type", "should be a number")
        return value


def problem_of(error: ValidationError) -> str:
    """What is wrong with the first value that does not fit, such as "should be a whole number"."""
    first = error.errors(include_url=False)[0]
    kind = str(first["type"])
    wanted = next((words for begin, words in _SHOULD_BE.items() if kind.startswith(f"{begin}_") or kind == begin), None)
    if wanted is not None and kind not in ("string_too_short", "string_pattern_mismatch"):
        return f"should be {wanted}"
    return str(first["msg"]).removeprefix("Input ").removeprefix("Value error, ")
