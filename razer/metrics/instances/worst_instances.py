"""Worst-case list: the true instances with the lowest best IoU, with the ids to look them up by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from razer.metrics.instances.matching import Overlaps


@dataclass(frozen=True, slots=True)
class WorstInstance:
    """A true instance and the prediction that overlaps it most, None where none does; vertices: of the truth."""

    scene: str
    truth: int
    truth_class: str | None
    vertices: int
    predicted: int | None
    predicted_class: str | None
    iou: float


def worst_instances(
    scene: str,
    overlaps: Overlaps,
    truth_classes: Mapping[int, str],
    predicted_classes: Mapping[int, str],
    min_region: int,
    count: int,
) -> tuple[WorstInstance, ...]:
    """The `count` true instances with the lowest best intersection over union.

    Args:
        scene: its name.
        overlaps: shared vertices of true and predicted instances.
        truth_classes: class names by true instance id.
        predicted_classes: class names by predicted instance id.
        min_region: vertices of the smallest truth that is listed.
        count: how many.
    """
    iou = overlaps.iou
    best = iou.argmax(axis=1) if iou.shape[1] else np.zeros(len(iou), np.int64)
    rows = []
    for row in np.flatnonzero(overlaps.truth_sizes >= min_region).tolist():
        value = float(iou[row, best[row]]) if iou.shape[1] else 0.0
        number = int(overlaps.truth_ids[row])
        partner = int(overlaps.predicted_ids[best[row]]) if value > 0 else None
        partner_class = None if partner is None else predicted_classes.get(partner)
        size = int(overlaps.truth_sizes[row])
        rows.append(WorstInstance(scene, number, truth_classes.get(number), size, partner, partner_class, value))
    return worst_of(rows, count)


def worst_of(instances: Iterable[WorstInstance], count: int) -> tuple[WorstInstance, ...]:
    """The `count` worst, the worst first; of equal ones the larger first."""
    return tuple(sorted(instances, key=lambda w: (w.iou, -w.vertices, w.scene, w.truth))[:count])
