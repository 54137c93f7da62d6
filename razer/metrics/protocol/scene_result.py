"""Evaluation of one scene: match outcomes and counts that can be pooled with those of other scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from razer.arrays import Int64Array
from razer.metrics.instances.instance_ap import Scene, SceneOutcomes, match_scene, scores_of
from razer.metrics.instances.match_summary import MatchSummary, summarize_matches
from razer.metrics.instances.matching import Overlaps
from razer.metrics.instances.name_outcomes import NameOutcome, name_outcomes
from razer.metrics.instances.panoptic_quality import PanopticCounts, count_segments, merge_stuff
from razer.metrics.instances.prediction_account import PredictionAccount, account_for
from razer.metrics.instances.recall_by_views import ViewedInstance
from razer.metrics.instances.retrieval import RetrievalCounts, given_mask_retrieval, predicted_mask_retrieval
from razer.metrics.instances.worst_instances import WorstInstance, worst_instances
from razer.metrics.preset import Preset
from razer.metrics.protocol.prediction_grounds import prediction_grounds
from razer.metrics.protocol.scene_labels import SceneLabels, class_by_vertices, labels_on_truth
from razer.metrics.protocol.scene_overlap import SceneOverlap, scene_overlap
from razer.metrics.protocol.vertex_masks import VertexMasks
from razer.metrics.relation_scores import RelationCounts, RelationScene, count_relations
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.semantic_segmentation import confusion
from razer.metrics.surface.surface_errors import SurfaceMetrics, surface_distances, surface_metrics
from razer.metrics.trajectory_errors import TrajectoryMetrics, trajectory_metrics

MAIN_LIST = ""


@dataclass(frozen=True, slots=True)
class InstanceResult:
    """Instances of one scene. agnostic: all classes merged. aware: by list of classes, the preset's own under "".
    named: whether any prediction has an evaluated class. account: what became of each prediction; confidences, by id,
    None where it has none. views: of each true instance that counts, None where not known. groups: class name -> split
    of the vocabulary. names: of the matches."""

    agnostic: SceneOutcomes
    aware: Mapping[str, SceneOutcomes] | None
    named: bool
    match_summary: MatchSummary
    account: PredictionAccount
    confidences: Mapping[int, float] | None
    views: tuple[ViewedInstance, ...] | None
    n_truth: int
    n_predicted: int
    panoptic_agnostic: Mapping[Any, PanopticCounts]
    panoptic_aware: Mapping[Any, PanopticCounts] | None
    groups: Mapping[str, str]
    worst: tuple[WorstInstance, ...]
    names: tuple[NameOutcome, ...]


@dataclass(frozen=True, slots=True)
class SceneResult:
    """Results of one scene; None for parts that do not apply. n_frames: poses of the prediction's trajectory;
    unknown_names: names that the list lacks."""

    name: str
    instances: InstanceResult | None
    confusion: Counter[tuple[str, str]] | None
    retrieval_given: RetrievalCounts | None
    retrieval_partners: RetrievalCounts | None
    surface: SurfaceMetrics | None
    overlap: SceneOverlap | None
    pose: TrajectoryMetrics | None
    relations: RelationCounts | None
    n_frames: int
    unknown_names: frozenset[str]


def evaluate_scene(name: str, truth: TruthScene, predicted: PredictedScene, preset: Preset) -> SceneResult:
    """Evaluate one scene.

    Args:
        name: of the scene, for the list of worst instances.
        truth: ground truth on V vertices.
        predicted: the prediction; its surface may lie in the frame of its own trajectory.
        preset: the rules.

    Raises:
        ValueError: where predicted labels or masks do not fit the truth's vertices.
    """
    pose = _pose(truth, predicted)
    predicted = _moved(predicted, pose)
    labels = labels_on_truth(truth, predicted, preset)
    overlaps = None if labels.predicted_instances is None else _scene(labels, _evaluated(labels, preset)).overlaps()
    distances = surface_distances(truth, predicted)
    instances = None
    if overlaps is not None:
        grounds = prediction_grounds(truth, predicted, labels, distances, _evaluated(labels, preset), preset)
        instances = _instances(name, labels, overlaps, grounds, _views(predicted, pose), preset)
    return SceneResult(
        name,
        instances,
        _confusion(labels),
        _retrieval_given(labels, predicted, preset),
        None if overlaps is None else _retrieval_partners(labels, preset),
        surface_metrics(truth, predicted, distances),
        scene_overlap(distances),
        # Given poses would be compared with themselves.
        pose if predicted.own_frame else None,
        _relations(labels, truth, predicted, preset),
        0 if predicted.trajectory is None else len(predicted.trajectory.stamps),
        frozenset(name for name in _names(truth, predicted) if not labels.table.number(name)),
    )


def in_frame_of_truth(truth: TruthScene, predicted: PredictedScene) -> PredictedScene:
    """The prediction, where it lies in the frame of its own trajectory brought to that of the truth's."""
    return _moved(predicted, _pose(truth, predicted))


def _moved(predicted: PredictedScene, pose: TrajectoryMetrics | None) -> PredictedScene:
    if not predicted.own_frame or pose is None or predicted.vertices is None:
        return predicted
    motion = pose.truth_from_estimate
    return replace(predicted, vertices=predicted.vertices @ motion[:3, :3].T + motion[:3, 3])


def _names(truth: TruthScene, predicted: PredictedScene) -> set[str]:
    """The class names that truth and prediction use."""
    names = {*predicted.class_names.values(), *(predicted.names_of_truth or {}).values()}
    for classes, named in ((truth.classes, truth.class_names), (predicted.classes, predicted.vertex_class_names)):
        used = [] if classes is None else np.unique(classes).tolist()
        names |= {named[number] for number in used if number > 0 and number in named}
    return names - {""}


def _pose(truth: TruthScene, predicted: PredictedScene) -> TrajectoryMetrics | None:
    if truth.trajectory is None or predicted.trajectory is None:
        return None
    return trajectory_metrics(truth.trajectory, predicted.trajectory)


def _relations(
    labels: SceneLabels, truth: TruthScene, predicted: PredictedScene, preset: Preset
) -> RelationCounts | None:
    if truth.relations is None or predicted.relations is None:
        return None
    stuff = labels.table.subset(preset.stuff)
    stuff_of = {number: c for number, c in labels.truth_instance_classes.items() if c in stuff}
    scene = RelationScene(
        labels.truth_instances,
        labels.single_instances,
        truth.relations,
        predicted.relations,
        stuff_of,
        preset.min_region,
    )
    return count_relations(scene)


def _evaluated(labels: SceneLabels, preset: Preset, classes: tuple[str, ...] | None = None) -> set[int]:
    """The numbers of the classes whose instances are evaluated."""
    chosen = labels.table.subset(preset.instance_classes if classes is None else classes, all_if_empty=True)
    return chosen - labels.table.subset(preset.instance_ignored)


def _scene(labels: SceneLabels, evaluated: set[int], aware: bool = False) -> Scene:
    """The scene with only truths of the evaluated classes; where the truth knows no class at all, with all of them."""
    names = labels.table.names
    classes = {i: names[c] for i, c in labels.truth_instance_classes.items() if c in evaluated}
    truth = labels.truth_instances
    if labels.truth_instance_classes:
        truth = np.where(np.isin(truth, list(classes)), truth, 0)
    predicted = VertexMasks({}, len(truth)) if labels.predicted_instances is None else labels.predicted_instances
    own = {i: names[c] for i, c in labels.predicted_instance_classes.items() if c in evaluated}
    return Scene(truth, predicted, labels.scores, classes if aware else None, own if aware else None)


def _views(predicted: PredictedScene, pose: TrajectoryMetrics | None) -> Mapping[int, int] | None:
    """How many frames of the prediction's trajectory show each true instance, None where that is not known."""
    if predicted.views_of_truth is None or predicted.trajectory is None or (predicted.own_frame and pose is None):
        return None
    motion = pose.truth_from_estimate if predicted.own_frame and pose is not None else np.eye(4)
    return predicted.views_of_truth(motion @ predicted.trajectory.world_from_camera)


def _instances(
    name: str,
    labels: SceneLabels,
    overlaps: Overlaps,
    grounds: Mapping[int, Int64Array],
    views: Mapping[int, int] | None,
    preset: Preset,
) -> InstanceResult:
    evaluated = _evaluated(labels, preset)
    scene = _scene(labels, evaluated)
    scores = scores_of(scene, overlaps)
    summary = summarize_matches(overlaps, scores, preset.min_region, preset.strict)
    things = {i for i, c in labels.predicted_instance_classes.items() if c in evaluated}
    account = account_for(overlaps, summary, grounds, things, preset.min_region)
    truths = overlaps.truth_ids[overlaps.truth_sizes >= preset.min_region].tolist()
    single, names = labels.single_instances, labels.table.names
    return InstanceResult(
        match_scene(scene, overlaps, preset.ap_settings),
        _aware(labels, overlaps, preset) if labels.truth_instance_classes else None,
        bool(things),
        summary._replace(duplicates=account.pieces),
        account,
        labels.scores or None,
        None if views is None else _viewed(truths, views, summary),
        len(truths),
        sum(map(len, account)),
        count_segments(scene.truth, single, min_region=preset.panoptic_min_region),
        _panoptic(labels, single, evaluated, preset) if labels.truth_instance_classes else None,
        labels.table.groups,
        worst_instances(
            name,
            overlaps,
            {i: names[c] for i, c in labels.truth_instance_classes.items()},
            {i: names[c] for i, c in labels.predicted_instance_classes.items()},
            preset.min_region,
            preset.worst,
        ),
        name_outcomes(
            summary.matches, labels.truth_instance_classes, labels.predicted_instance_classes, labels.name_probabilities
        ),
    )


def _viewed(truths: Sequence[int], views: Mapping[int, int], summary: MatchSummary) -> tuple[ViewedInstance, ...]:
    matched = {match.truth for match in summary.matches}
    return tuple(ViewedInstance(views.get(number, 0), number in matched) for number in truths)


def _aware(labels: SceneLabels, overlaps: Overlaps, preset: Preset) -> dict[str, SceneOutcomes]:
    """Match outcomes by class for each list of classes."""
    main = _scene(labels, _evaluated(labels, preset), aware=True)
    outcomes = {MAIN_LIST: match_scene(main, overlaps, preset.ap_settings)}
    for title, classes in preset.class_lists.items():
        scene = _scene(labels, _evaluated(labels, preset, classes), aware=True)
        outcomes[title] = match_scene(scene, scene.overlaps(), preset.ap_settings)
    return outcomes


def _panoptic(
    labels: SceneLabels, single: Int64Array, evaluated: set[int], preset: Preset
) -> dict[Any, PanopticCounts]:
    """Things as instances, stuff merged, by class name."""
    stuff = labels.table.subset(preset.stuff)
    counted = evaluated | stuff
    predicted_classes = np.zeros_like(single) if labels.predicted_classes is None else labels.predicted_classes
    sides = (
        merge_stuff(labels.truth_instances, labels.truth_classes, labels.truth_instance_classes, stuff),
        merge_stuff(single, predicted_classes, labels.predicted_instance_classes, stuff),
    )
    (truth, truth_names), (predicted, predicted_names) = (
        (segments, {i: labels.table.names[c] for i, c in classes.items() if c in counted})
        for segments, classes in sides
    )
    return count_segments(truth, predicted, truth_names, predicted_names, preset.panoptic_min_region)


def _confusion(labels: SceneLabels) -> Counter[tuple[str, str]] | None:
    if labels.predicted_classes is None or not labels.truth_classes.any():
        return None
    return confusion(labels.truth_classes, labels.predicted_classes, labels.table.names)


def _retrieval_classes(labels: SceneLabels, preset: Preset) -> dict[int, str]:
    """The class names of the true instances that are queried."""
    chosen = labels.table.subset(preset.retrieval_classes) or _evaluated(labels, preset)
    return {i: labels.table.names[c] for i, c in labels.truth_instance_classes.items() if c in chosen}


def _retrieval_given(labels: SceneLabels, predicted: PredictedScene, preset: Preset) -> RetrievalCounts | None:
    """The truth's masks with the classes given to them, or else, where predicted instances have classes, with those
    that most of their vertices are predicted."""
    if predicted.names_of_truth is not None:
        numbers = labels.table.numbers(predicted.names_of_truth)
    elif labels.predicted_classes is not None and labels.predicted_instance_classes and labels.truth_instance_classes:
        numbers = class_by_vertices(labels.truth_instances, labels.predicted_classes)
    else:
        return None
    given = {i: labels.table.names[c] for i, c in numbers.items()}
    return given_mask_retrieval(_retrieval_classes(labels, preset), given)


def _retrieval_partners(labels: SceneLabels, preset: Preset) -> RetrievalCounts | None:
    if not labels.predicted_instance_classes or not labels.truth_instance_classes:
        return None
    queried = _retrieval_classes(labels, preset)
    overlaps = _scene(labels, set(labels.table.names)).overlaps()
    own = {i: labels.table.names[c] for i, c in labels.predicted_instance_classes.items()}
    missed_is_wrong = preset.retrieval_missed == "wrong"
    return predicted_mask_retrieval(overlaps, queried, own, preset.retrieval_min_iou, missed_is_wrong)
