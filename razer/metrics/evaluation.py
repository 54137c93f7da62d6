"""The evaluator: pairs of truth and prediction in, every number of the protocols out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from razer.metrics.presets import Preset
from razer.metrics.scene_pair import PredictedScene, TruthScene

Pair = tuple[str, TruthScene, PredictedScene]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """All numbers of one evaluation, by the preset's rules. Parts that do not apply are None.

    curves: class name ("any" for class-agnostic) -> dict of arrays score, precision, recall (N,) at overlap 0.5.
    confusion: names (C,) and counts (C, C), truth by prediction, the first name "" for unlabelled.
    worst: the instances that went worst, with scene, id, class, best partner and IoU. scenes: numbers by scene."""

    preset: Preset
    class_agnostic: Mapping[str, Any] | None = None
    class_aware: Mapping[str, Any] | None = None
    semantic: Mapping[str, Any] | None = None
    panoptic: Mapping[str, Any] | None = None
    surface: Mapping[str, Any] | None = None
    retrieval: Mapping[str, Any] | None = None
    pose: Mapping[str, Any] | None = None
    duplicates: int | None = None
    missed: int | None = None
    curves: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    confusion: Mapping[str, Any] | None = None
    worst: tuple[Mapping[str, Any], ...] = ()
    scenes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """The machine-readable contract: plain JSON values only, null where a part does not apply or is no number."""
        raise NotImplementedError


def evaluate(pairs: Iterable[Pair], preset: Preset) -> Evaluation:
    """Evaluate (name, truth, prediction) scene by scene by the preset's rules; only one scene is held at a time, what
    is kept of it are judgements and counts."""
    raise NotImplementedError
