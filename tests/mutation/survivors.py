"""Mutants that no test kills and why, as survivors.toml lists them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

Key = tuple[str, str, str]


@cache
def listed_reasons() -> dict[Key, str]:
    """The reason for each survivor (path, line as it was, line as it becomes)."""
    groups = tomllib.loads(Path(__file__).with_name("survivors.toml").read_text(encoding="utf-8")).get("survivors", [])
    return {
        (group["path"], change["was"], becomes): group["reason"]
        for group in groups
        for change in group["changes"]
        for becomes in change["becomes"]
    }


def outdated(keys: Iterable[Key], root: Path) -> list[Key]:
    """Those whose line as it was no longer stands in the file."""

    def text_of(path: str) -> str:
        file = root / path
        return " ".join(line.strip() for line in file.read_text(encoding="utf-8").splitlines()) if file.exists() else ""

    return [key for key in keys if key[1] not in text_of(key[0])]
