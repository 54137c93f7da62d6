"""Evaluation of a run, or of another system's prediction, against the ground truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.evaluation.class_numbers import class_numbers
from app.evaluation.export import Export
from app.evaluation.predicted_relations import with_relations
from app.evaluation.prediction import LabelMeaning, Naming, read_prediction
from app.evaluation.view_counts import view_counter
from app.run_folder.run_folder import CONFIG
from app.run_folder.timed_poses import timed_poses
from app.run_folder.world_frame import map_origin
from app.settings.config_file import read_run_config
from data_tools import open_sequence
from data_tools.recordings.image_files import ImageFiles
from data_tools.recordings.local_origin import HERE, Origin, local_origin, moved_origin
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import open_truth
from razer.errors import BadInput, UnusableFrame
from razer.metrics.class_table import FROM_TRUTH
from razer.metrics.presets import Preset
from razer.metrics.protocol.scene_result import SceneResult, evaluate_scene
from razer.metrics.scene_pair import PredictedScene, TimedPoses, TruthScene
from razer.plugins import NO_TRUST, Trust
from razer.storage.file_names import is_map_folder

Job = tuple[str, Path, Path]


@dataclass(frozen=True)
class Reading:
    """How predictions are read, and what becomes of them beside. naming: where a run's instances get their classes, as
    in `read_prediction`. scene: which scene, where a folder holds several. labels: what numbers below 1000 in a file of
    vertex labels are. trust: which outside code may be loaded for a run's embedder. export: where predictions are
    written, as they are evaluated; None = nowhere."""

    naming: Naming = "auto"
    scene: str | None = None
    labels: LabelMeaning = "instance"
    trust: Trust = NO_TRUST
    export: Export | None = None


@dataclass(frozen=True)
class EvaluatedJob:
    """The result of a scene, to be pooled with those of others, and what the readers of the truth remark, and what was
    exported, in words."""

    result: SceneResult
    notes: tuple[str, ...]


def evaluate_job(job: Job, preset: Preset, reading: Reading) -> EvaluatedJob:
    """Evaluate one scene by the preset's rules. Raises BadInput, naming the prediction that does not fit its truth."""
    name, prediction, truth_folder = job
    truth = truth_for(truth_folder, preset, reading.scene)
    notes = [*truth.notes]
    try:
        predicted = read_prediction(
            prediction,
            truth.class_names,
            len(truth.vertices),
            numbers=class_numbers(preset, truth),
            naming=reading.naming,
            template=preset.text_template,
            scene=reading.scene,
            labels=reading.labels,
            trust=reading.trust,
        )
        true_scene = truth_scene(truth, true_poses(truth_folder), map_origin(prediction))
        if reading.export is not None:
            notes.append(reading.export.write(name, true_scene, predicted, preset))
        predicted = with_map(predicted, prediction, true_scene, preset)
        return EvaluatedJob(evaluate_scene(name, true_scene, predicted, preset), tuple(notes))
    except BadInput:
        raise
    except ValueError as error:
        raise BadInput(f"{prediction} does not fit {truth_folder}: {error}") from error


def with_map(predicted: PredictedScene, prediction: Path, truth: TruthScene, preset: Preset) -> PredictedScene:
    """A prediction that is a map with what only maps have: relations, where the truth states any, and what counts the
    views of the truth, if it is a run that knows its camera."""
    if truth.relations is not None and is_map_folder(prediction):
        predicted = with_relations(predicted, prediction, preset.stuff)
    if predicted.trajectory is None or not (prediction / CONFIG).is_file():
        return predicted
    return replace(predicted, views_of_truth=view_counter(prediction, read_run_config(prediction / CONFIG), truth))


def truth_for(folder: Path, preset: Preset, scene: str | None = None) -> GroundTruth:
    """The truth in a folder, in the classes of a preset; raises BadInput."""
    vocabulary = None if preset.vocabulary == FROM_TRUTH else preset.vocabulary
    return open_truth(folder, vocabulary=vocabulary, scene=scene)


def truth_scene(truth: GroundTruth, trajectory: TimedPoses | None = None, origin: Origin = HERE) -> TruthScene:
    """A ground truth as the evaluator takes it, as seen from the origin of a run's map, or from one of its own where it
    lies far from zero; surface outside the view of all frames does not count."""
    origin = local_origin(truth.vertices) if origin == HERE else origin
    if trajectory is not None:
        poses = trajectory.world_from_camera.astype(np.float64)
        trajectory = replace(trajectory, world_from_camera=moved_origin(poses, origin))
    return TruthScene(
        truth.vertices if origin == HERE else (truth.vertices - np.array(origin)).astype(np.float32),
        truth.instances,
        truth.classes,
        truth.class_names,
        triangles=truth.triangles,
        evaluated=truth.visible.astype(np.bool_),
        trajectory=trajectory,
        relations=truth.relations,
    )


def true_poses(folder: Path) -> TimedPoses | None:
    """The poses of the recording that a truth belongs to: in the folder, or in the one around a folder `truth`."""
    for place in (folder, folder.absolute().parent) if folder.absolute().name == "truth" else (folder,):
        if (place / "trajectory.txt").is_file():
            return timed_poses(place / "trajectory.txt")
        try:
            sequence = open_sequence(place)
        except BadInput:
            continue
        if isinstance(sequence, RecordedSequence) and isinstance(sequence.images, ImageFiles) and sequence.has_poses:
            return _poses_of(sequence)
    return None


def _poses_of(sequence: RecordedSequence) -> TimedPoses | None:
    assert sequence.pose_of is not None
    pose_of_stamp = {}
    for index in range(len(sequence)):
        try:
            pose_of_stamp[sequence.images.stamp(index)] = sequence.pose_of(index)[0]
        except UnusableFrame:
            continue
    stamps = sorted(pose_of_stamp)
    return TimedPoses(np.array(stamps), np.stack([pose_of_stamp[s] for s in stamps]), len(sequence)) if stamps else None
