"""Mutants that no test kills and why, as survivors.toml lists them."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path


@cache
def listed_reasons() -> dict[tuple[str, str, str], str]:
    """The reason for each survivor (path, line as it was, line as it becomes)."""
    groups = tomllib.loads(Path(__file__).with_name("survivors.toml").read_text(encoding="utf-8")).get("survivors", [])
    return {
        (group["path"], change["was"], becomes): group["reason"]
        for group in groups
        for change in group["changes"]
        for becomes in change["becomes"]
    }
