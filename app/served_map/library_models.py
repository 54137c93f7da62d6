"""Questions to a library of maps and answers as JSON."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from app.served_map.answer_models import MAX_HITS, MAX_TEXT

MAX_FILTER = 1000  # characters


class LibraryQuery(BaseModel):
    """What to look for in all maps: a text, or an instance to find others like."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"text": "a red chair", "where": "height_m < 1"}]}
    )

    text: str | None = Field(None, min_length=1, max_length=MAX_TEXT, description='Such as "a red chair with wheels".')
    like: str | None = Field(None, max_length=MAX_FILTER, description="An instance, as RUN:ID, in place of a text.")
    where: str | None = Field(None, max_length=MAX_FILTER, description="A filter in SQL over the library's columns.")
    limit: int = Field(10, ge=1, le=MAX_HITS)
    by_scene: bool = Field(False, description="Whether the hits are grouped by scene, too.")
    table: str | None = Field(None, max_length=100, description="Of several models' tables the one that is asked.")


class LibraryHitRecord(BaseModel):
    """An instance of one of the maps."""

    model_config = ConfigDict(extra="allow")

    run: str
    scene: str
    id: int
    score: float = Field(description="Probability that it is what was asked for; for pictures, likeness.")
    class_: str | None = Field(alias="class")
    center: list[float] = Field(description="Metres, in the map's own frame.")
    extent: list[float]
    map: str = Field(description="The address of its map on this server.")


class LibraryAnswerRecord(BaseModel):
    """What was found in all maps, the most probable first, and the same said in words."""

    format: Literal[1] = 1
    query: str
    found: bool
    statement: str
    threshold: float
    asked: int = Field(description="How many instances passed the filter.")
    hits: list[LibraryHitRecord]
    scenes: list[dict[str, Any]] | None = None


class LibraryMaps(BaseModel):
    """The maps of a library."""

    format: Literal[1] = 1
    maps: list[dict[str, Any]]
