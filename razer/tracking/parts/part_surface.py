"""Surface of parts: which vertices of a whole each of its parts has, once all views are in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float32Array, IndexArray, Int32Array
from razer.config import MapperConfig
from razer.tracking.parts.cell_votes import MAJORITY
from razer.tracking.parts.part_track import PartTrack
from razer.tracking.track import Track

DOUBLE_IOU = 0.5  # of two parts that are one


@dataclass(frozen=True)
class PartSurface:
    """A part with its rows (n,) of the vertices of a mesh, ascending; whole, the id of the track that it is of."""

    whole: int
    track: Track
    vertices: IndexArray


def part_surfaces(
    parts: Mapping[int, Sequence[PartTrack]], vertices: Float32Array, instances: Int32Array, config: MapperConfig
) -> list[PartSurface]:
    """The parts that exist, by whole and the largest first; no vertex is of two of them.

    Args:
        parts: Those of each track, by its id; they stay as they are.
        vertices: Of the mesh (V, 3), metres.
        instances: The track (V,) of each.
        config: What confirms a track, and how large the smallest is.
    """
    order = np.argsort(instances, kind="stable")
    found = []
    for whole in sorted(parts):
        rows = order[slice(*np.searchsorted(instances, [whole, whole + 1], sorter=order))]
        confirmed = [p for p in parts[whole] if p.owner == whole and _is_confirmed(p.track, config)]
        held = [_surface(whole, part, rows, vertices, config) for part in confirmed]
        enough = [surface for surface in held if len(surface.vertices) >= config.lifting.min_cells]
        found += _exclusive(_distinct(enough), config)
    return found


def _is_confirmed(track: Track, config: MapperConfig) -> bool:
    """Whether it is a part as tracks are instances: rather there than not, at the end of a run."""
    return track.hits > 1 and track.confirmed and track.confidence >= config.maintenance.min_confidence


def _surface(
    whole: int, part: PartTrack, rows: IndexArray, vertices: Float32Array, config: MapperConfig
) -> PartSurface:
    """What a part has of its whole's vertices, given by their rows."""
    size_m = config.voxels.voxel_size_m
    low, high = part.votes.bounds_m(size_m)
    near = rows[((vertices[rows] >= low) & (vertices[rows] <= high)).all(axis=1)]
    return PartSurface(whole, part.track, near[part.votes.hold(vertices[near].astype(np.float64), size_m)])


def _distinct(surfaces: Sequence[PartSurface]) -> list[PartSurface]:
    """Without doubles, of which the one stays that is surer to be there."""
    kept: list[PartSurface] = []
    for surface in sorted(surfaces, key=lambda s: (-s.track.existence.log_odds, -len(s.vertices), s.track.id)):
        if all(_iou(surface.vertices, other.vertices) <= DOUBLE_IOU for other in kept):
            kept.append(surface)
    return kept


def _iou(one: IndexArray, other: IndexArray) -> float:
    shared = len(np.intersect1d(one, other, assume_unique=True))
    return shared / max(len(one) + len(other) - shared, 1)


def _exclusive(surfaces: Sequence[PartSurface], config: MapperConfig) -> list[PartSurface]:
    """Each vertex for the smallest part that has it; what is left of a union of smaller parts is none. The largest
    first."""
    taken = np.zeros(0, np.intp)
    kept = []
    for surface in sorted(surfaces, key=lambda s: (len(s.vertices), s.track.id)):
        own = np.setdiff1d(surface.vertices, taken, assume_unique=True)
        if len(own) >= max(MAJORITY * len(surface.vertices), config.lifting.min_cells):
            kept.append(replace(surface, vertices=own))
            taken = np.union1d(taken, own)
    return kept[::-1]
