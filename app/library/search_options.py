"""What a search of a library can be asked besides a text, as the command line has it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.settings.options import Assignments
from razer.errors import BadInput


@Parameter(name="*")
@dataclass(frozen=True)
class SearchOptions:
    """A picture or an instance in place of a text; which instances are asked, by which model, and how many hits."""

    k: Annotated[int, Parameter(name=["-k"])] = 5
    """Maximum number of hits."""
    where: str | None = None
    """A filter in SQL, such as "class = 'chair' and height_m < 1"; docs/library.md has the columns."""
    image: Path | None = None
    """An image of what to look for, instead of a text."""
    box: str | None = None
    """The part of it that counts, as x,y,width,height in pixels."""
    like: str | None = None
    """An instance to find others like, as RUN:ID."""
    min_score: float | None = None
    """Minimum score of a hit, from 0 to 1. Lower: higher recall, lower precision."""
    table: str | None = None
    """Of a library with vectors of several models, the table that is asked."""
    embedder: str | None = None
    """Embedder, a name or module:Class; the one of the table if not given."""
    set: Assignments = ()
    """One setting as section.key=value, such as an embedder's option; may be repeated."""

    def check(self, text: str | None) -> None:
        """Raise BadInput where these and a text do not go together."""
        if sum(each is not None for each in (text, self.image, self.like)) != 1:
            raise BadInput(
                "give one of these: a text to look for, a picture with --image, an instance with --like RUN:ID"
            )
        if self.k < 1 or (self.min_score is not None and not 0 <= self.min_score <= 1):
            raise BadInput("-k is at least 1, and --min-score from 0 to 1")
        if self.box is not None and self.image is None:
            raise BadInput("--box is a part of the picture that --image names")
