"""Answers about a whole map as JSON: queries, relations, scene graph."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from app.served_map.instance_models import ClassGuess

MAX_TEXT = 500  # characters; what is longer is no description of a thing
MAX_HITS = 1000


class TextQuery(BaseModel):
    """What to look for, in words."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"text": "a red chair", "limit": 5}]})

    text: str = Field(min_length=1, max_length=MAX_TEXT, description='Such as "a red chair", "something to sit on".')
    limit: int = Field(10, ge=1, le=MAX_HITS)


class QueryHit(BaseModel):
    """An instance that a query means."""

    id: int
    name: str
    probability: float = Field(description="That it is what was asked for.")
    score: float = Field(description="Confidence that there is such an instance.")
    runner_up: ClassGuess | None = Field(description="What else it may be, where that is within reach.")
    center_m: list[float]
    extent_m: list[float]


_FOUND: JsonDict = {
    "format": 1,
    "epoch": 0,
    "query": "chair",
    "found": True,
    "statement": "1 instance in this map is meant by: chair",
    "hits": [
        {
            "id": 12,
            "name": "chair",
            "probability": 0.97,
            "score": 0.98,
            "runner_up": None,
            "center_m": [1.2, 0.4, 0.45],
            "extent_m": [0.5, 0.52, 0.9],
        }
    ],
}
_NOT_FOUND: JsonDict = {
    "format": 1,
    "epoch": 0,
    "query": "piano",
    "found": False,
    "statement": "not in this map: piano",
    "hits": [],
}


class QueryAnswer(BaseModel):
    """What a query found, the most probable first, and the same said in words."""

    model_config = ConfigDict(json_schema_extra={"examples": [_FOUND, _NOT_FOUND]})

    format: Literal[1] = 1
    epoch: int
    query: str
    found: bool
    statement: str
    hits: list[QueryHit]


class MapRelation(BaseModel):
    """`subject` is `relation` `object`, as in: 4 is on 1."""

    subject: int
    relation: str = Field(examples=["on"])
    object: int


class RelationList(BaseModel):
    """All relations of the instances of a map."""

    format: Literal[1] = 1
    epoch: int
    relations: list[MapRelation]


class SceneGraph(BaseModel):
    """Things and merged stuff as nodes, relations as edges, as in scene_graph.json."""

    format: Literal[1] = 1
    epoch: int
    nodes: list[dict[str, Any]]
    edges: list[dict[str, Any]]
