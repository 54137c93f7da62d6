"""Instances of a map as JSON: the models of `instances` and what filters them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

MAX_ID = 2**31 - 1  # what a mesh holds

InstanceId = Annotated[int, Field(ge=1, le=MAX_ID, description="Number of an instance.")]
Kind = Literal["thing", "stuff"]
_CHAIR: JsonDict = {
    "id": 12,
    "name": "chair",
    "probability": 0.91,
    "class_guesses": [{"name": "chair", "probability": 0.91}, {"name": "stool", "probability": 0.04}],
    "kind": "thing",
    "score": 0.98,
    "center_m": [1.2, 0.4, 0.45],
    "extent_m": [0.5, 0.52, 0.9],
    "orientation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    "n_frames": 41,
    "first_frame": 3,
    "last_frame": 120,
    "parts": [],
    "part_of": None,
    "crops": 3,
    "edited": False,
    "vertices": 5321,
}


class ClassGuess(BaseModel):
    """A name that an instance may have, with its probability."""

    name: str
    probability: float = Field(ge=0, le=1)


class Instance(BaseModel):
    """One thing, one surface that is not counted (stuff), or a part of a thing."""

    model_config = ConfigDict(json_schema_extra={"examples": [_CHAIR]})

    id: InstanceId
    name: str = Field(description="The most probable name; thing or part where nothing is known of names.")
    probability: float | None = Field(ge=0, le=1, description="Of that name; null where nothing tells.")
    class_guesses: list[ClassGuess]
    kind: Kind
    score: float = Field(description="Confidence that there is such an instance, 0 to 1.")
    center_m: list[float] = Field(description="Centre of the box in the world, metres.")
    extent_m: list[float] = Field(description="Sides of the box along its own axes, metres.")
    orientation: list[list[float]] = Field(description="3x3; its columns are the axes of the box in the world.")
    n_frames: int
    first_frame: int
    last_frame: int
    parts: list[int]
    part_of: int | None
    crops: int = Field(description="How many pictures there are of it: crop/0.jpg and on, the best first.")
    edited: bool
    vertices: int


class InstanceRelation(BaseModel):
    """How an instance stands to another: it is `relation` the other."""

    relation: str = Field(examples=["on"])
    other: int
    other_name: str


class InstanceList(BaseModel):
    """A page of the instances that pass the filters."""

    format: Literal[1] = 1
    epoch: int
    total: int = Field(description="How many pass the filters, on this page and on others.")
    instances: list[Instance]


class InstanceDetail(Instance):
    """One instance with its relations."""

    format: Literal[1] = 1
    epoch: int
    relations: list[InstanceRelation]


class InstanceFilter(BaseModel):
    """Which instances are wanted, and which page of them."""

    model_config = ConfigDict(populate_by_name=True, extra="forbid")

    class_: str | None = Field(None, alias="class", max_length=200, description="Name, as in `name`.")
    kind: Kind | None = None
    min_score: float | None = Field(None, ge=0, le=1)
    min_extent_m: float | None = Field(None, ge=0, le=1e6, description="Of the longest side.")
    text: str | None = Field(None, max_length=200, description="Part of a name, or a number.")
    offset: int = Field(0, ge=0, le=MAX_ID)
    limit: int = Field(100, ge=1, le=1000)

    def passes(self, instance: Instance) -> bool:
        """Whether an instance is wanted."""
        name = instance.name.casefold()
        return (
            (self.class_ is None or name == self.class_.casefold())
            and (self.kind is None or instance.kind == self.kind)
            and (self.min_score is None or instance.score >= self.min_score)
            and (self.min_extent_m is None or max(instance.extent_m) >= self.min_extent_m)
            and (self.text is None or self.text.casefold() in name or self.text.lstrip("#") == str(instance.id))
        )
