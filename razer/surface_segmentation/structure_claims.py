"""Structure by geometry over names by masks: a floor takes back what coarse masks of other things spilled on it. Class
maps of semantic models end some pixels beside the edge where two surfaces meet, on the same side in many views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.arrays import Int32Array, Int64Array
from razer.boxes.oriented_box import OrientedBox
from razer.config.surface_segmentation import SurfaceSegmentationSettings
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.surface_segmentation.segmentation import structure_pieces

_OWNER_SHARE = 0.3  # of a piece of structure that its stuff instance has at least; else the masks meant something else
_FLAT_SHARE = 0.5  # of an instance that lies in the plane: more, and it is flat itself, a rug, a door or a poster


def with_claimed_structure(
    panoptic: PanopticMap, settings: SurfaceSegmentationSettings, *, voxel_size_m: float
) -> PanopticMap:
    """The map in which each plane of structure belongs to the stuff that has most of it. What other instances have of
    it is theirs only if they lie in it with more than half of their surface.

    Args:
        panoptic: the map by masks; its volume keeps the masks' labels.
        settings: of the segmentation that finds the planes.
        voxel_size_m: the volume's.
    """
    mesh = panoptic.mesh
    claimed = mesh.instances.copy()
    by_id = {item.id: item for item in panoptic.objects}
    for members in structure_pieces(mesh, panoptic.up_or_z, settings):
        _claim(claimed, members, by_id)
    changed = np.unique(np.concatenate([side[claimed != mesh.instances] for side in (claimed, mesh.instances)]))
    left = [_refreshed(o, mesh, claimed, voxel_size_m) if o.id in changed else o for o in panoptic.objects]
    objects = tuple(item for item in left if item is not None)
    parts = None if panoptic.vertex_parts is None else np.where(claimed == mesh.instances, panoptic.vertex_parts, 0)
    return replace(panoptic, objects=objects, mesh=replace(mesh, instances=claimed), vertex_parts=parts)


def _claim(labels: Int32Array, members: Int64Array, by_id: dict[int, MapObject]) -> None:
    """Give a piece of structure, the vertices (M,), to the stuff that has most of it, in labels (V,)."""
    within = labels[members]
    shares = np.bincount(within, minlength=max(by_id, default=0) + 1) / len(members)
    owner = max((i for i, item in by_id.items() if item.is_stuff), key=lambda i: (shares[i], -i), default=None)
    if owner is None or shares[owner] < _OWNER_SHARE:
        return
    totals = np.bincount(labels, minlength=len(shares))
    is_flat = shares * len(members) > _FLAT_SHARE * totals
    is_same = np.zeros(len(shares), np.bool_)
    is_same[[i for i, item in by_id.items() if item.class_name == by_id[owner].class_name]] = True
    is_flat[0] = False
    labels[members] = np.where((is_flat & ~is_same)[within], within, owner)
    labels[np.isin(labels, np.flatnonzero(is_flat & is_same))] = owner  # with what of a piece sticks out


def _refreshed(item: MapObject, mesh: LabelledMesh, labels: Int32Array, voxel_size_m: float) -> MapObject | None:
    """The instance with the surface that it has by new labels (V,); None if it has none."""
    points = mesh.vertices[labels == item.id].astype(np.float64)
    if not len(points):
        return None
    n_voxels = len(np.unique(np.rint(points / voxel_size_m), axis=0))
    return replace(item, box=OrientedBox.of_surface(points), n_voxels=n_voxels, n_vertices=len(points))
