"""Upright planes by a Hough transform in plan, in connected patches; walls are those that no larger plane stands behind
(furniture along a wall has fronts, too)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array, IntArray
from razer.surface_segmentation.surface import HEIGHT, Surface

_UPRIGHT = 0.25  # largest cosine of a normal with the vertical
_AZIMUTHS = 72
_OFFSET_M = 0.05
_MIN_LINE_M2 = 0.3
_MAX_LINES = 80
_REFINEMENTS = ((0.08, 20.0), (0.05, 15.0), (0.04, 15.0))  # distance in metres and angle in degrees of what is fitted
_THICKNESS_M = 0.04
_MEMBER_DEG = 30.0
_MIN_VERTICES = 50
_CELL_M = 0.06  # of the picture of a plane, in which gaps of up to 8 cells, as behind a picture, are closed
_CLOSING = 9
_MIN_AREA_M2, _MIN_HEIGHT_M, _MIN_LENGTH_M = 0.8, 1.3, 0.5  # of a wall
_PARALLEL_DEG = 12.0
_IN_FRONT_M = (-0.12, 0.9)  # how far a front of furniture, or a door in its frame, stands before its wall
_SAME_PLANE_M = 0.025
_BEHIND_SHARE = 0.6


@dataclass(frozen=True)
class PlanePatch:
    """A connected part of an upright plane: members (M,) vertex numbers, normal (2,) in plan, offset_m along it, the
    ranges of its members along the plane and in height, metres, and its area."""

    members: Int64Array
    normal: Float64Array
    offset_m: float
    along_m: tuple[float, float]
    height_m: tuple[float, float]
    area_m2: float

    @property
    def direction(self) -> Float64Array:
        """The level direction (2,) along the plane."""
        return np.array([-self.normal[1], self.normal[0]])


def wall_patches(surface: Surface) -> list[PlanePatch]:
    """The walls of a map, whatever hangs on them or has another colour."""
    patches = [patch for line in _upright_planes(surface) for patch in _patches(surface, *line)]
    large = [
        patch
        for patch in patches
        if patch.area_m2 > _MIN_AREA_M2
        and np.ptp(patch.height_m) > _MIN_HEIGHT_M
        and np.ptp(patch.along_m) > _MIN_LENGTH_M
    ]
    return [patch for patch in large if not any(_stands_before(surface, patch, other) for other in large)]


def _upright_planes(surface: Surface) -> Iterator[tuple[Int64Array, Float64Array, float]]:
    """Planes with the most surface first: members (M,), normal (2,) in plan, offset in metres."""
    left = np.flatnonzero(np.abs(surface.normals[:, HEIGHT]) < _UPRIGHT)
    for _ in range(_MAX_LINES):
        plane = _strongest_line(surface, left)
        if plane is None:
            return
        is_member = _members(surface, left, *plane, _THICKNESS_M, _MEMBER_DEG)
        if is_member.sum() < _MIN_VERTICES:
            is_member = _members(surface, left, *plane, _OFFSET_M, _MEMBER_DEG)
        else:
            yield left[is_member], *plane
        if not is_member.any():
            return
        left = left[~is_member]


def _strongest_line(surface: Surface, left: Int64Array) -> tuple[Float64Array, float] | None:
    """Normal (2,) and offset of the line in plan with the most area of the vertices `left`, fitted to them."""
    if not len(left):
        return None
    normals, points, areas = surface.normals[left, :2], surface.positions[left, :2], surface.areas[left]
    turn = np.round(np.arctan2(normals[:, 1], normals[:, 0]) / (2 * np.pi) * _AZIMUTHS).astype(np.int64) % _AZIMUTHS
    angles = np.arange(_AZIMUTHS) * 2 * np.pi / _AZIMUTHS
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    offset = np.floor((points * directions[turn]).sum(axis=1) / _OFFSET_M).astype(np.int64)
    lowest, n_offsets = offset.min(), np.ptp(offset) + 1
    votes = np.bincount(turn * n_offsets + offset - lowest, areas)
    best = int(votes.argmax())
    if votes[best] < _MIN_LINE_M2:
        return None
    normal, offset_m = directions[best // n_offsets], (best % n_offsets + lowest + 0.5) * _OFFSET_M
    for distance_m, angle_deg in _REFINEMENTS:
        chosen = _members(surface, left, normal, offset_m, distance_m, angle_deg)
        if chosen.sum() < _MIN_VERTICES:
            break
        normal, offset_m = _fitted_line(points[chosen], areas[chosen], normal)
    return normal, offset_m


def _members(
    surface: Surface, left: Int64Array, normal: Float64Array, offset_m: float, distance_m: float, angle_deg: float
) -> BoolArray:
    """Which of the vertices `left` lie in a plane and face as it does."""
    is_near = np.abs(surface.positions[left, :2] @ normal - offset_m) < distance_m
    facing: BoolArray = surface.normals[left, :2] @ normal > np.cos(np.radians(angle_deg))
    return is_near & facing


def _fitted_line(points: Float64Array, areas: Float64Array, facing: Float64Array) -> tuple[Float64Array, float]:
    middle = np.average(points, axis=0, weights=areas)
    centred = points - middle
    normal = np.linalg.eigh((centred * areas[:, None]).T @ centred)[1][:, 0]
    normal = normal if normal @ facing > 0 else -normal
    return normal, float(middle @ normal)


def _patches(surface: Surface, members: Int64Array, normal: Float64Array, offset_m: float) -> Iterator[PlanePatch]:
    """The connected parts of a plane, seen flat on."""
    along = surface.positions[members, :2] @ np.array([-normal[1], normal[0]])
    height = surface.positions[members, HEIGHT]
    column, row = (np.floor((values - values.min()) / _CELL_M).astype(np.int64) for values in (along, height))
    number = _connected(column, row)
    order = np.argsort(number, kind="stable")
    for part in np.split(order, np.flatnonzero(np.diff(number[order])) + 1):
        if len(part) >= _MIN_VERTICES:
            ranges = [(float(values[part].min()), float(values[part].max())) for values in (along, height)]
            area = float(surface.areas[members[part]].sum())
            yield PlanePatch(members[part], normal, offset_m, ranges[0], ranges[1], area)


def _connected(column: IntArray, row: IntArray) -> IntArray:
    """The number of the connected region of each cell (M,), gaps closed."""
    margin = _CLOSING // 2
    picture = np.zeros((column.max() + 1 + 2 * margin, row.max() + 1 + 2 * margin), np.uint8)
    picture[column + margin, row + margin] = 1
    closed = cv2.morphologyEx(picture, cv2.MORPH_CLOSE, np.ones((_CLOSING, _CLOSING), np.uint8))
    numbers: IntArray = cv2.connectedComponents(closed, connectivity=4)[1][column + margin, row + margin]
    return numbers


def _stands_before(surface: Surface, patch: PlanePatch, other: PlanePatch) -> bool:
    """Whether a larger parallel plane as high is right behind a patch, which then is no wall."""
    if other is patch or other.area_m2 < 1.3 * patch.area_m2 or other.height_m[1] < patch.height_m[1] - 0.15:
        return False
    if other.normal @ patch.normal < np.cos(np.radians(_PARALLEL_DEG)):
        return False
    points = surface.positions[patch.members, :2]
    before_m = float(points.mean(axis=0) @ other.normal - other.offset_m)
    if not _IN_FRONT_M[0] < before_m < _IN_FRONT_M[1] or abs(before_m) < _SAME_PLANE_M:
        return False
    along = points @ other.direction
    is_covered = (along > other.along_m[0] - 0.1) & (along < other.along_m[1] + 0.1)
    return bool(is_covered.mean() > _BEHIND_SHARE)
