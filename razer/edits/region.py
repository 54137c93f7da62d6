"""Regions of space that an edit picks vertices by: one side of a plane, or a lasso drawn on a picture of the map."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from razer.arrays import BoolArray, Float64Array

MAX_CORNERS = 2000  # of a lasso: a minute of a moving pointer has fewer

Number = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]


def _direction(normal: tuple[float, float, float]) -> tuple[float, float, float]:
    if not np.linalg.norm(normal) > 1e-9:
        raise ValueError("the normal of a plane has a length")
    return normal


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Plane(_Part):
    """The half space n.x >= offset_m; metres, world axes, a normal of any length."""

    normal: Annotated[tuple[Number, Number, Number], AfterValidator(_direction)]
    offset_m: Number

    def holds(self, points: Float64Array) -> BoolArray:
        """Which of (N, 3) points lie in it."""
        held: BoolArray = points @ np.array(self.normal) >= self.offset_m
        return held


class Lasso(_Part):
    """What lies inside a polygon on a picture, in front of its camera: clip_from_world (16,) by rows, so that
    (x, y, z, w) = M (p, 1) and x/w, y/w are normalised device coordinates, in which the polygon (P, 2) is given."""

    clip_from_world: Annotated[list[Number], Field(min_length=16, max_length=16)]
    polygon: Annotated[list[tuple[Number, Number]], Field(min_length=3, max_length=MAX_CORNERS)]

    def holds(self, points: Float64Array) -> BoolArray:
        """Which of (N, 3) points lie in it, by the even-odd rule."""
        matrix = np.array(self.clip_from_world).reshape(4, 4)
        clip = points @ matrix[:, :3].T + matrix[:, 3]
        held: BoolArray = clip[:, 3] > 1e-9
        held[held] = inside_polygon(clip[held, :2] / clip[held, 3:], np.array(self.polygon))
        return held


class Region(_Part):
    """A plane or a lasso."""

    plane: Plane | None = None
    lasso: Lasso | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Region:
        if (self.plane is None) == (self.lasso is None):
            raise ValueError("a region is either a plane or a lasso")
        return self

    def holds(self, points: Float64Array) -> BoolArray:
        """Which of (N, 3) world points, metres, lie in it."""
        shape = self.plane or self.lasso
        assert shape is not None
        return shape.holds(points)


def inside_polygon(points: Float64Array, polygon: Float64Array) -> BoolArray:
    """Which of (N, 2) points a ray to the right leaves a polygon (P, 2) from, through an odd number of its edges."""
    x, y = points.T
    inside = np.zeros(len(points), np.bool_)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            inside ^= crosses & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return inside
