"""The result: instances with boxes and embeddings, and the labelled surface (section III-G)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from razer.boxes import OrientedBox
from razer.surface import LabelledMesh
from razer.track import Track
from razer.views import View


@dataclass(frozen=True)
class MapObject:
    """One instance: id >= 1; score, the track's confidence alpha in [0, 1]; embeddings (J, D) float32 of unit
    length with weights (J,) adding up to 1; views, the frames that show it best, the best first."""

    id: int
    class_name: str | None
    score: float
    box: OrientedBox
    n_voxels: int
    n_vertices: int
    observations: int
    first_frame: int
    last_frame: int
    embeddings: NDArray[np.float32]
    weights: NDArray[np.float64]
    views: tuple[View, ...] = ()


@dataclass(frozen=True)
class PanopticMap:
    """Objects by id and the mesh whose vertices bear their ids."""

    objects: tuple[MapObject, ...]
    mesh: LabelledMesh

    @classmethod
    def of(cls, tracks: Sequence[Track], mesh: LabelledMesh) -> PanopticMap:
        """Freeze tracks and mesh; vertices of ids that are no object become nobody's."""
        known = np.array(sorted(track.id for track in tracks), dtype=np.int32)
        instances = np.where(np.isin(mesh.instances, known), mesh.instances, 0).astype(np.int32)
        counts = np.bincount(instances, minlength=1)
        objects = [_frozen(t, int(counts[t.id]) if t.id < len(counts) else 0) for t in tracks]
        mesh = LabelledMesh(mesh.vertices, mesh.colors, instances, mesh.triangles)
        return cls(tuple(sorted(objects, key=lambda o: o.id)), mesh)


def _frozen(track: Track, n_vertices: int) -> MapObject:
    return MapObject(
        id=track.id,
        class_name=track.class_name,
        score=track.confidence,
        box=track.box,
        n_voxels=track.n_voxels,
        n_vertices=n_vertices,
        observations=track.hits,
        first_frame=track.first_frame,
        last_frame=track.last_frame,
        embeddings=track.bank.embeddings,
        weights=track.bank.confidences,
        views=track.views,
    )
