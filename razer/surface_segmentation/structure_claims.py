"""Structure by geometry over names by masks: a floor takes back what coarse masks of other things spilled on it. Class
maps of semantic models end some pixels beside the edge where two surfaces meet, on the same side in many views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.arrays import Int32Array, Int64Array
from razer.config.surface_segmentation import SurfaceSegmentationSettings
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.surface_segmentation.segmentation import structure_pieces
from razer.tracking.parts.frozen_parts import parts_on_wholes

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
    before, labels = panoptic.mesh.instances, panoptic.mesh.instances.copy()
    by_id = {item.id: item for item in panoptic.objects}
    for members in structure_pieces(panoptic.mesh, panoptic.up_or_z, settings.at_voxels(voxel_size_m)):
        _claim(labels, members, by_id)
    mesh = replace(panoptic.mesh, instances=labels)
    changed = {*labels[labels != before].tolist(), *before[labels != before].tolist()}
    left = [_on_own_surface(item, mesh) if item.id in changed else item for item in panoptic.objects]
    claimed = replace(panoptic, objects=tuple(item for item in left if item is not None), mesh=mesh)
    if panoptic.vertex_parts is None:
        return claimed
    unmoved = np.where(labels == before, panoptic.vertex_parts, 0)  # stuff, which takes the rest, has no parts
    parts, vertex_parts = parts_on_wholes(panoptic.parts, mesh, unmoved)
    return replace(claimed, parts=parts, vertex_parts=vertex_parts if parts else None)


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


def _on_own_surface(item: MapObject, mesh: LabelledMesh) -> MapObject | None:
    """The instance with the surface that a mesh says it has; None without any."""
    points = mesh.vertices[mesh.instances == item.id].astype(np.float64)
    return item.on_surface(points) if len(points) else None
