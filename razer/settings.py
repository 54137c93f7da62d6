"""The base of all settings: frozen, checked, unknown names refused."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Settings(BaseModel):
    """A frozen group of settings; unknown names are refused and ranges are checked."""

    model_config = ConfigDict(frozen=True, extra="forbid")
