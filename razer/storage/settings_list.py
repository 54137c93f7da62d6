"""Every setting as one flat list: name, value, allowed range, meaning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting: `section` and `key` make its dotted name; `allowed` is its range or its choices."""

    section: str
    key: str
    value: Any
    default: Any
    allowed: str
    meaning: str

    @property
    def name(self) -> str:
        """The name that --set takes, such as voxels.voxel_size_m."""
        return f"{self.section}.{self.key}" if self.section else self.key


def list_settings(config: BaseModel) -> list[Setting]:
    """The settings of a configuration in the order of declaration, those without a section first."""
    return sorted(_walk(config, type(config)(), ""), key=lambda setting: bool(setting.section))


def _walk(config: BaseModel, defaults: BaseModel, section: str) -> list[Setting]:
    found: list[Setting] = []
    for key, field in type(config).model_fields.items():
        value, default = getattr(config, key), getattr(defaults, key)
        if isinstance(value, BaseModel):
            found += _walk(value, default, f"{section}.{key}" if section else key)
        else:
            found.append(Setting(section, key, value, default, allowed(field), field.description or ""))
    return found


def allowed(field: FieldInfo) -> str:
    """The range of a number or the choices of a literal as text; empty where anything of the type goes."""
    if get_origin(field.annotation) is Literal:
        return ", ".join(str(choice) for choice in get_args(field.annotation))
    bounds = [
        f"{_SIGNS[name]} {getattr(item, name)}" for item in field.metadata for name in _SIGNS if hasattr(item, name)
    ]
    return " and ".join(bounds)
