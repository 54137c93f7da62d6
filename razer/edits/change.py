"""What each kind of edit does to a map."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import singledispatch

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int32Array
from razer.edits.changed_objects import pooled
from razer.edits.edit import Delete, Edit, Merge, MoveBorder, Relabel, Rename, Split
from razer.edits.region import Region
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.models.stuff_names import is_stuff_name
from razer.panoptic_map import PanopticMap
from razer.tracking.parts.frozen_parts import parts_on_wholes

MIN_VERTICES = 4  # of what is split off or left: less has no box worth the name


@singledispatch
def changed(edit: Edit, panoptic: PanopticMap) -> PanopticMap:
    """A map after an edit whose instances it has; raises BadInput where the edit is impossible."""
    raise TypeError(f"{edit!r} is no edit")


@changed.register
def _rename(edit: Rename, panoptic: PanopticMap) -> PanopticMap:
    item = instance(panoptic, edit.instance)
    return _with(panoptic, [replace(item, class_name=edit.name, is_edited=True, is_named_by_hand=True)])


@changed.register
def _relabel(edit: Relabel, panoptic: PanopticMap) -> PanopticMap:
    item, name = instance(panoptic, edit.instance), edit.class_name
    stuff = is_stuff_name(name)
    return _with(panoptic, [replace(item, class_name=name, is_stuff=stuff, is_edited=True, is_named_by_hand=True)])


@changed.register
def _merge(edit: Merge, panoptic: PanopticMap) -> PanopticMap:
    kept, *others = [instance(panoptic, i) for i in edit.instances]
    gone = [item.id for item in others]
    labels = np.where(np.isin(panoptic.mesh.instances, gone), kept.id, panoptic.mesh.instances).astype(np.int32)
    parts = tuple(replace(part, part_of=kept.id) if part.part_of in gone else part for part in panoptic.parts)
    merged = pooled(kept, others, _points(panoptic, labels == kept.id))
    return replace(_with(panoptic, [merged], labels, gone=gone), parts=parts)


@changed.register
def _delete(edit: Delete, panoptic: PanopticMap) -> PanopticMap:
    item = instance(panoptic, edit.instance)
    labels = np.where(panoptic.mesh.instances == item.id, 0, panoptic.mesh.instances).astype(np.int32)
    return _with_parts_on_their_wholes(_with(panoptic, [], labels, gone=[item.id]))


@changed.register
def _split(edit: Split, panoptic: PanopticMap) -> PanopticMap:
    assert edit.new is not None
    item = instance(panoptic, edit.instance)
    labels = _moved(panoptic, item, edit.region, edit.new)
    sides = [
        replace(item, id=i, is_edited=True).on_surface(_points(panoptic, labels == i)) for i in (item.id, edit.new)
    ]  # votes, views and embeddings are of both: which side they were of is not known
    return _with_parts_on_their_wholes(_with(panoptic, sides, labels))


@changed.register
def _move_border(edit: MoveBorder, panoptic: PanopticMap) -> PanopticMap:
    source, target = instance(panoptic, edit.source), instance(panoptic, edit.target)
    labels = _moved(panoptic, source, edit.region, target.id)
    sides = [
        replace(item, is_edited=True).on_surface(_points(panoptic, labels == item.id)) for item in (source, target)
    ]
    return _with_parts_on_their_wholes(_with(panoptic, sides, labels))


def instance(panoptic: PanopticMap, number: int) -> MapObject:
    """The instance of this id; raises BadInput where there is none."""
    for item in panoptic.objects:
        if item.id == number:
            return item
    for part in panoptic.parts:
        if part.id == number:
            raise BadInput(f"{number} is a part of instance {part.part_of}: edits are of whole instances")
    raise BadInput(f"there is no instance {number} in this map")


def called(item: MapObject) -> str:
    """An instance as messages call it: "chair #12"."""
    return f"{item.class_name or 'instance'} #{item.id}"


def _moved(panoptic: PanopticMap, source: MapObject, region: Region, target: int) -> Int32Array:
    """The labels (V,) once what of an instance lies in a region bears another id."""
    labels = panoptic.mesh.instances.copy()
    rows = np.flatnonzero(labels == source.id)
    inside = region.holds(panoptic.mesh.vertices[rows].astype(np.float64))
    for n, where in ((int(inside.sum()), "in"), (int((~inside).sum()), "outside")):
        if n < MIN_VERTICES:
            raise BadInput(f"{'nothing' if not n else 'next to nothing'} of {called(source)} lies {where} the region")
    labels[rows[inside]] = target
    return labels


def _points(panoptic: PanopticMap, mask: BoolArray) -> Float64Array:
    return panoptic.mesh.vertices[mask].astype(np.float64)


def _with(
    panoptic: PanopticMap, items: Iterable[MapObject], labels: Int32Array | None = None, gone: Iterable[int] = ()
) -> PanopticMap:
    """A map with some instances renewed or added, some gone, and other labels (V,) where they are given."""
    by_id = {item.id: item for item in panoptic.objects} | {item.id: item for item in items}
    objects = tuple(by_id[i] for i in sorted(by_id.keys() - set(gone)))
    mesh = panoptic.mesh if labels is None else replace(panoptic.mesh, instances=labels)
    return replace(panoptic, objects=objects, mesh=mesh)


def _with_parts_on_their_wholes(panoptic: PanopticMap) -> PanopticMap:
    """The same with each part on the instance that has most of its vertices, and on no other; parts of which nothing is
    left are gone."""
    if panoptic.vertex_parts is None:
        return panoptic
    parts, of_part = parts_on_wholes(panoptic.parts, panoptic.mesh, panoptic.vertex_parts)
    whole = {part.id: part.n_vertices for part in panoptic.parts}
    edited = tuple(part if part.n_vertices == whole[part.id] else replace(part, is_edited=True) for part in parts)
    return replace(panoptic, parts=edited, vertex_parts=of_part if parts else None)
