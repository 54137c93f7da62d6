"""Next-best-view planning: few places and directions from which nearly all of a scan is seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.camera.camera_path import EYE_M
from data_tools.synthetic.layout.free_space import FreeSpace
from data_tools.synthetic.scans.surface import ScannedSurface
from razer.arrays import BoolArray, Float32Array, Float64Array, Int64Array

_APART_M = 0.7
_MOST_PLACES = 150
_RANGE_M = (0.5, 4.0)
_PATCH_M = 0.15
# Rays in all directions from a place, and of them those that a camera sees when it looks one way.
_AZIMUTHS, _PITCHES_DEG = 90, np.arange(-66.0, 39.0, 5.0)
_HEADINGS, _LOOKS_DEG = 24, (-28.0, -8.0)
_HALF_VIEW_DEG = (28.0, 22.0)
# Enough is seen when the next view adds fewer patches (of some 120 that it can meet) and a small share of what can be
# seen, or little is left.
_LEAST_PATCHES, _LEAST_SHARE, _ENOUGH = 40, 0.03, 0.985


@dataclass(frozen=True, slots=True)
class View:
    """Where the camera stands (x, y), metres, and which way it looks: heading about z and pitch, radians."""

    place: tuple[float, float]
    heading: float
    pitch: float


def plan_views(surface: ScannedSurface, space: FreeSpace, seed: int) -> list[View]:
    """Views that together see nearly all that can be seen within 4 m from where the camera can be, greedily: each next
    one sees most that none before has seen. The seed says where places are tried."""
    places = _spread(space.places, seed)
    patches = np.stack([_patches_around(surface, place) for place in places])
    known, numbers = np.unique(patches, return_inverse=True)
    numbers = numbers.reshape(patches.shape)
    empty = known[0] < 0
    seen_by = [(place, *look, _seen(numbers[place], *look)) for place in range(len(places)) for look in _looks()]
    starts = np.concatenate([[0], np.cumsum([len(view[3]) for view in seen_by])[:-1]])
    every = np.concatenate([view[3] for view in seen_by])
    fresh = np.ones(len(known), bool)
    fresh[: int(empty)] = False
    total, views = int(fresh.sum()), list[View]()
    while total and fresh.sum() > (1 - _ENOUGH) * total:
        gains = np.add.reduceat(fresh[every].astype(np.int64), starts)
        best = int(gains.argmax())
        if views and gains[best] < max(1, min(_LEAST_PATCHES, _LEAST_SHARE * total)):
            break
        place, heading, pitch, patches_seen = seen_by[best]
        views.append(View((float(places[place][0]), float(places[place][1])), heading, pitch))
        fresh[patches_seen] = False
    return views


def _spread(places: Float64Array, seed: int) -> Float64Array:
    """Some of the places, each as far as can be from those before, until all are near one."""
    first = int(np.random.default_rng([seed, 31]).integers(len(places)))
    chosen = [first]
    distance = np.linalg.norm(places - places[first], axis=1)
    while len(chosen) < _MOST_PLACES and distance.max() > _APART_M:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return places[chosen]


def _patches_around(surface: ScannedSurface, place: Float64Array) -> Int64Array:
    """The patch of surface (pitches, azimuths) in each direction from a place, -1 for none within range."""
    azimuth, pitch = np.meshgrid(2 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS, np.radians(_PITCHES_DEG))
    level = np.cos(pitch)
    rays = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(pitch)], axis=-1).astype(np.float32)
    eye: Float32Array = np.array([*place, EYE_M], np.float32)
    distance, triangle, _ = surface.cast(eye, rays)
    met = (triangle >= 0) & (distance > _RANGE_M[0]) & (distance < _RANGE_M[1])
    points = eye + rays * np.where(met, distance, 0)[..., None]
    cells = np.floor(points / _PATCH_M).astype(np.int64) + 2**19
    return np.where(met, (cells[..., 0] << 40) | (cells[..., 1] << 20) | cells[..., 2], -1)


def _looks() -> list[tuple[float, float]]:
    return [
        (2 * np.pi * k / _HEADINGS, float(np.radians(pitch_deg))) for k in range(_HEADINGS) for pitch_deg in _LOOKS_DEG
    ]


def _seen(numbers: Int64Array, heading: float, pitch: float) -> Int64Array:
    """The patches, once each, that a camera that looks this way sees of those around its place."""
    around = 2 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS - heading
    wide: BoolArray = np.cos(around) > np.cos(np.radians(_HALF_VIEW_DEG[0]))
    high: BoolArray = np.abs(_PITCHES_DEG - np.degrees(pitch)) < _HALF_VIEW_DEG[1]
    return np.unique(numbers[high][:, wide])
