"""Model catalogue: what can be fetched by name, with source, checksums and licence."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from types import MappingProxyType

from razer.errors import BadInput

_WITHOUT = {
    "segmenter": "without it, '--segmenter geometric' finds masks from depth and colour",
    "embedder": "without it, '--embedder appearance' maps as well, but knows no words",
}


@dataclass(frozen=True)
class CatalogueEntry:
    """One model: `use` names the segmenter or embedder that takes it as `weights`; files of `repo` at `revision` on
    the Hugging Face Hub, as names or patterns; sha256 by file name where publicly known; accept, what has to be
    accepted before a download, if anything; also, options that it cannot be used without; page, where its publisher
    describes it; tried, what of it has run here with real weights, '' = nothing; needs, a package of the extra
    "transformers" without which it cannot be used."""

    name: str
    use: str
    about: str
    repo: str
    revision: str
    files: tuple[str, ...]
    licence: str
    megabytes: int
    accept: str = ""
    sha256: Mapping[str, str] = field(default_factory=dict)
    also: tuple[str, ...] = ()
    page: str = ""
    tried: str = ""
    needs: str = ""

    @property
    def task(self) -> str:
        """segmenter or embedder."""
        return self.use.split()[0]

    @property
    def part(self) -> str:
        """The name of the segmenter or embedder."""
        return self.use.split()[1]

    @property
    def patterns(self) -> bool:
        """Whether the hub's listing is needed to know which files there are."""
        return any("*" in name for name in self.files)

    @property
    def how_to_get(self) -> str:
        """The command that fetches it, and what works without."""
        return f"run '{self.pull_command}'; {_WITHOUT[self.task]}"

    @property
    def pull_command(self) -> str:
        """The command that fetches it."""
        return f"razer models pull {self.name}{' --accept-license' if self.accept else ''}"


@cache
def catalogue() -> Mapping[str, CatalogueEntry]:
    """All entries by name, in the order of the table."""
    table = tomllib.loads((files("razer.models.hub") / "catalogue.toml").read_text(encoding="utf-8"))
    rows = {
        name: CatalogueEntry(name, **{**row, "files": tuple(row["files"]), "also": tuple(row.get("also", ()))})
        for name, row in table.items()
    }
    return MappingProxyType(rows)


def entry(name: str) -> CatalogueEntry:
    """The entry called `name`; raises BadInput that names the nearest ones."""
    entries = catalogue()
    if name in entries:
        return entries[name]
    near = get_close_matches(name, entries, 3, 0.4) or list(entries)
    raise BadInput(f"no model '{name}' in the catalogue: did you mean {', '.join(near)}? 'razer models list' has all")
