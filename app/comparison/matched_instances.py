"""The instances of two maps in one frame, side by side."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from razer.map_object import MapObject
from razer.metrics.instances.instance_pairs import pair_instances
from razer.panoptic_map import PanopticMap


@dataclass(frozen=True)
class MatchedInstance:
    """One thing in both maps, and the overlap of its surface."""

    a: MapObject
    b: MapObject
    iou: float

    @property
    def center_distance_m(self) -> float:
        """From one box's centre to the other's."""
        return float(np.linalg.norm(self.a.box.center - self.b.box.center))

    @property
    def cosine(self) -> float | None:
        """The largest cosine of any two embeddings; None where there are none of one length."""
        one, other = self.a.embeddings, self.b.embeddings
        if not one.size or not other.size or one.shape[1] != other.shape[1]:
            return None
        return float((one @ other.T).max())

    def as_json(self) -> dict[str, Any]:
        """Ids, classes, places and sizes of both, and how alike they are."""
        a, b = self.a, self.b
        return {
            "a": a.id,
            "b": b.id,
            "class_a": a.class_name,
            "class_b": b.class_name,
            "iou": self.iou,
            "center_distance_m": self.center_distance_m,
            "center_a_m": a.box.center.tolist(),
            "center_b_m": b.box.center.tolist(),
            "extent_a_m": a.box.extent.tolist(),
            "extent_b_m": b.box.extent.tolist(),
            "cosine": self.cosine,
        }


@dataclass(frozen=True)
class Matching:
    """What both maps have, what A alone has (missed) and what B alone has (extra)."""

    matched: tuple[MatchedInstance, ...]
    missed: tuple[MapObject, ...]
    extra: tuple[MapObject, ...]

    def as_json(self) -> dict[str, list[dict[str, Any]]]:
        """A list of each kind."""
        return {
            "matched": [match.as_json() for match in self.matched],
            "missed": [_alone(found) for found in self.missed],
            "extra": [_alone(found) for found in self.extra],
        }


def match_instances(a: PanopticMap, b: PanopticMap) -> Matching:
    """Match the instances of two maps in one frame by their surfaces; those without a surface do not count."""
    of_a, of_b = ({o.id: o for o in one.objects if o.n_vertices} for one in (a, b))
    pairs = pair_instances(a.mesh.vertices, a.mesh.instances, b.mesh.vertices, b.mesh.instances)
    return Matching(
        tuple(MatchedInstance(of_a[pair.a], of_b[pair.b], pair.iou) for pair in pairs),
        _without(of_a.values(), {pair.a for pair in pairs}),
        _without(of_b.values(), {pair.b for pair in pairs}),
    )


def _without(objects: Iterable[MapObject], ids: set[int]) -> tuple[MapObject, ...]:
    return tuple(o for o in objects if o.id not in ids)


def _alone(found: MapObject) -> dict[str, Any]:
    return {
        "id": found.id,
        "class": found.class_name,
        "center_m": found.box.center.tolist(),
        "extent_m": found.box.extent.tolist(),
    }
