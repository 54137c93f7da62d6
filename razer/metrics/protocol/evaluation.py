"""The evaluator: pairs of truth and prediction in, every number of the protocols out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from razer.metrics.instances.precision_recall import Curve
from razer.metrics.instances.worst_instances import WorstInstance, worst_of
from razer.metrics.preset import Preset
from razer.metrics.protocol import instances_over_scenes, over_scenes
from razer.metrics.protocol.scene_result import SceneResult, evaluate_scene
from razer.metrics.scene_pair import PredictedScene, TruthScene

Pair = tuple[str, TruthScene, PredictedScene]
Numbers = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """All numbers of one evaluation, by the preset's rules. Parts that do not apply are None, numbers without a value
    (a class without truth) nan.

    duplicates, missed, n_truth, n_predicted: instances, regardless of class and at an overlap of 0.5. curves: precision
    over recall at 0.5 by class, "any" for all merged. confusion: names (C,), "" for none, and counts, C rows of C, true
    by predicted class. scenes: the same numbers of each scene, with the ids of what matched, doubled or was missed."""

    preset: Preset
    class_agnostic: Numbers | None = None
    class_aware: Numbers | None = None
    semantic: Numbers | None = None
    panoptic: Numbers | None = None
    surface: Numbers | None = None
    duplicates: int | None = None
    missed: int | None = None
    pose: Numbers | None = None
    n_truth: int | None = None
    n_predicted: int | None = None
    retrieval: Numbers | None = None
    confusion: Numbers | None = None
    worst: tuple[WorstInstance, ...] = ()
    unknown_names: tuple[str, ...] = ()
    scenes: Mapping[str, Numbers] = field(default_factory=dict)
    curves: Mapping[str, Curve] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """The machine-readable contract: plain JSON values only, null where a part does not apply or is no number."""
        parts = {
            name: getattr(self, name) for name in Evaluation.__slots__ if name not in ("preset", "curves", "worst")
        }
        worst = [asdict(one) for one in self.worst]
        return plain_json({"preset": self.preset.name, "settings": self.preset.model_dump(), **parts, "worst": worst})


def evaluate(pairs: Iterable[Pair], preset: Preset) -> Evaluation:
    """Evaluate (name, truth, prediction) scene by scene by the preset's rules; only one scene is held at a time, what
    is kept of it are judgements and counts."""
    results: list[SceneResult] = []
    scenes: dict[str, Numbers] = {}
    for name, truth, predicted in pairs:
        results.append(evaluate_scene(name, truth, predicted, preset))
        scenes[name] = _scene_numbers(results[-1], preset)
        del truth, predicted
    return _summary(results, preset, scenes)


def _scene_numbers(result: SceneResult, preset: Preset) -> Numbers:
    """The numbers of one scene, without tables by class."""
    alone = _summary([result], preset, {})
    numbers = {
        name: _short(getattr(alone, name))
        for name in ("class_agnostic", "class_aware", "semantic", "panoptic", "surface", "retrieval", "pose")
    }
    found = None if result.instances is None else result.instances.found
    ids = {} if found is None else {"duplicates": found.duplicates, "missed": found.missed}
    matches = [] if found is None else [match._asdict() for match in found.matches]
    return numbers | {"n_truth": alone.n_truth, "n_predicted": alone.n_predicted, **ids, "matches": matches}


def _short(numbers: Numbers | None) -> Numbers | None:
    if numbers is None:
        return None
    return {key: value for key, value in numbers.items() if key not in ("per_class", "splits", "lists")}


def _summary(results: Sequence[SceneResult], preset: Preset, scenes: Mapping[str, Numbers]) -> Evaluation:
    instances = [r.instances for r in results if r.instances is not None]
    confusions = [r.confusion for r in results if r.confusion is not None]
    aware = instances_over_scenes.class_aware(instances, preset)
    found = [r.found for r in instances]
    return Evaluation(
        preset=preset,
        class_agnostic=instances_over_scenes.class_agnostic(instances, preset),
        class_aware=aware,
        semantic=over_scenes.semantic(confusions, preset),
        panoptic=instances_over_scenes.panoptic(instances, aware is not None, preset),
        surface=over_scenes.surface([r.surface for r in results if r.surface is not None]),
        duplicates=sum(len(f.duplicates) for f in found) if found else None,
        missed=sum(len(f.missed) for f in found) if found else None,
        pose=over_scenes.pose([r.pose for r in results if r.pose is not None]),
        n_truth=sum(r.n_truth for r in instances) if instances else None,
        n_predicted=sum(r.n_predicted for r in instances) if instances else None,
        retrieval=over_scenes.retrieval(
            [r.retrieval_given for r in results if r.retrieval_given is not None],
            [r.retrieval_partners for r in results if r.retrieval_partners is not None],
        ),
        confusion=over_scenes.confusion_table(confusions),
        worst=worst_of((w for r in instances for w in r.worst), preset.worst),
        unknown_names=tuple(sorted({name for r in results for name in r.unknown_names})),
        scenes=scenes,
        curves=instances_over_scenes.curves(instances, aware is not None),
    )


def plain_json(value: Any) -> Any:
    """The value with only what JSON has: nan and infinity become None, keys text, tuples lists."""
    if isinstance(value, Mapping):
        return {str(key): plain_json(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(part) for part in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
