"""A map whose instances are the segments of its surface: what the masks knew of them is carried over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray, Int32Array, Int64Array
from razer.boxes.oriented_box import OrientedBox
from razer.config.surface_segmentation import SurfaceSegmentationSettings
from razer.detection.best_views import best_views
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap
from razer.surface_segmentation.segmentation import segment_surface

_HYPOTHESES = 3  # embeddings of an instance, as in a bank


@dataclass(frozen=True)
class _Source:
    """An instance of the masks and how many vertices of a segment it has."""

    item: MapObject
    shared: int


def segmented_map(
    panoptic: PanopticMap, settings: SurfaceSegmentationSettings, *, voxel_size_m: float, newest_id: int = 0
) -> PanopticMap:
    """The map with segments of its surface as instances.

    A segment has embeddings and best views of the instances that it consists of, and the id of the one that is the same
    thing (more than half of either); the others get new ids.

    Args:
        panoptic: the map by masks; its volume keeps the masks' labels.
        settings: of the segmentation.
        voxel_size_m: the volume's.
        newest_id: new ids are larger than this and than all ids of the map.
    """
    mesh = panoptic.mesh
    segments = segment_surface(mesh, panoptic.up_or_z, settings.at_voxels(voxel_size_m))
    known = panoptic.objects
    shared = _shared_vertices(segments.labels, mesh.instances, [item.id for item in known], len(segments.names))
    members = _members(segments.labels, len(segments.names))
    ids = _ids(shared, [len(m) for m in members], known, max([newest_id, *(item.id for item in known)]))
    objects = []
    for row, (vertices, name) in enumerate(zip(members, segments.names, strict=True)):
        sources = [_Source(known[column], int(shared[row, column])) for column in np.flatnonzero(shared[row])]
        item = _object(ids[row], mesh.vertices[vertices].astype(np.float64), sources, voxel_size_m)
        item = replace(item, score=float(segments.scores[row]))
        objects.append(replace(item, class_name=name, is_stuff=True) if name else item)
    labels = np.concatenate([[0], ids]).astype(np.int32)[segments.labels]
    ordered = tuple(sorted(objects, key=lambda item: item.id))
    return replace(panoptic, objects=ordered, mesh=replace(mesh, instances=labels), parts=(), vertex_parts=None)


def _members(labels: Int32Array, n_segments: int) -> list[IndexArray]:
    """The vertices of each segment."""
    ends = np.cumsum(np.bincount(labels, minlength=n_segments + 1))
    return np.split(np.argsort(labels, kind="stable"), ends)[1:-1]


def _shared_vertices(labels: Int32Array, instances: Int32Array, known: Sequence[int], n_segments: int) -> Int64Array:
    """Vertices (S, I) that each segment shares with each of the known instances (I,), ids in order."""
    columns = np.searchsorted(known, instances)
    is_known = np.append(known, 0)[columns] == instances
    keys = (labels.astype(np.int64) * len(known) + columns)[is_known & (instances > 0)]
    return np.bincount(keys, minlength=(n_segments + 1) * len(known)).reshape(n_segments + 1, len(known))[1:]


def _ids(shared: Int64Array, sizes: Sequence[int], known: Sequence[MapObject], newest_id: int) -> list[int]:
    """The id of each segment: that of the instance which is the same thing, else a new one."""
    of_instance = np.array([item.n_vertices for item in known], np.int64)
    is_same = (2 * shared > np.array(sizes, np.int64)[:, None]) & (2 * shared > of_instance)  # one in a row or column
    new = iter(range(newest_id + 1, newest_id + len(shared) + 1))
    return [known[int(row.argmax())].id if row.any() else next(new) for row in is_same]


def _object(number: int, points: Float64Array, sources: Sequence[_Source], voxel_size_m: float) -> MapObject:
    """A segment as an instance: its own surface, with what is known of the instances that it consists of."""
    sources = sorted(sources, key=lambda source: (-source.shared, source.item.id))
    parts = [s for s in sources if 2 * s.shared >= s.item.n_vertices] or list(sources[:1])
    embeddings, weights = _bank(parts)
    return MapObject(
        id=number,
        class_name=parts[0].item.class_name if parts else None,
        score=0.0,
        box=OrientedBox.of_surface(points),
        n_voxels=len(np.unique(np.rint(points / voxel_size_m), axis=0)),
        n_vertices=len(points),
        observations=max((p.item.observations for p in parts), default=0),
        first_frame=min((p.item.first_frame for p in parts), default=0),
        last_frame=max((p.item.last_frame for p in parts), default=0),
        embeddings=embeddings,
        weights=weights,
        views=best_views(view for p in parts for view in p.item.views),
    )


def _bank(parts: Sequence[_Source]) -> tuple[Float32Array, Float64Array]:
    """The strongest embeddings (J, D) of the parts, and their weights (J,) by surface, adding up to 1."""
    parts = [part for part in parts if len(part.item.weights)]
    if not parts:
        return np.zeros((0, 0), np.float32), np.zeros(0)
    vectors = np.concatenate([part.item.embeddings for part in parts])
    weights = np.concatenate([part.shared * part.item.weights for part in parts])
    best = np.argsort(-weights, kind="stable")[:_HYPOTHESES]
    return vectors[best], weights[best] / weights[best].sum()
