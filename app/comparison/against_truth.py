"""Runs beside a truth whose frame they do not share: each is brought there by its trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from app.evaluation.evaluate_run import true_poses, truth_for, truth_scene
from app.evaluation.prediction import read_prediction
from app.run_folder.mapped_run import MappedRun
from razer.errors import BadInput
from razer.metrics.preset import Preset
from razer.metrics.protocol.evaluation import Evaluation, evaluate
from razer.metrics.scene_pair import TimedPoses, TruthScene
from razer.metrics.trajectory_errors import PoseErrors, TrajectoryMetrics, errors_over_time, trajectory_metrics
from razer.plugins import NO_TRUST, Trust

LEAST_POSES = 3


@dataclass(frozen=True)
class Truth:
    """What is true of a scene, with the trajectory in its frame."""

    scene: TruthScene
    trajectory: TimedPoses
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Measured:
    """A run's numbers in the frame of the truth, and how it got there."""

    evaluation: Evaluation
    pose: TrajectoryMetrics
    errors: PoseErrors


def open_scene(folder: Path, preset: Preset) -> Truth:
    """The truth in a folder; raises BadInput where it holds none, or no camera poses in its frame."""
    truth = truth_for(folder, preset)
    trajectory = true_poses(folder)
    if trajectory is None:
        raise BadInput(f"{folder} has no camera poses to align the runs by: give the recording's folder, or no --truth")
    return Truth(truth_scene(truth, trajectory), trajectory, tuple(truth.notes))


def measure(folder: Path, run: MappedRun, truth: Truth, preset: Preset, trust: Trust = NO_TRUST) -> Measured:
    """Evaluate a run in the frame of the truth; raises BadInput where too few of their stamps agree."""
    pose = compare_trajectories(truth.trajectory, run.trajectory, "the truth", str(folder))
    scene = truth.scene
    n_vertices, template = len(scene.vertices), preset.text_template
    predicted = read_prediction(folder, scene.class_names, n_vertices, template=template, trust=trust)
    evaluation = evaluate([(run.name, scene, replace(predicted, own_frame=True))], preset)
    return Measured(evaluation, pose, errors_over_time(truth.trajectory, run.trajectory, pose.truth_from_estimate))


def compare_trajectories(
    reference: TimedPoses, estimate: TimedPoses, reference_name: str, estimate_name: str
) -> TrajectoryMetrics:
    """The numbers of two trajectories; raises BadInput where fewer than LEAST_POSES of their stamps agree."""
    numbers = trajectory_metrics(reference, estimate)
    n_common = 0 if numbers is None else numbers.compared
    if numbers is None or n_common < LEAST_POSES:
        raise BadInput(
            f"{estimate_name} and {reference_name} have {n_common} stamps in common, {LEAST_POSES} are needed: "
            "are they of one recording?"
        )
    return numbers


def differences(a: Mapping, b: Mapping) -> dict[str, object]:
    """b - a for each number that two results of one shape have, None where either has none; what is neither number
    nor made up of some is left out."""
    return {key: _difference(a[key], b[key]) for key in a if key in b and _counts(a[key]) and _counts(b[key])}


def _difference(a: object, b: object) -> object:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return differences(a, b)
    return b - a if isinstance(a, int | float) and isinstance(b, int | float) else None


def _counts(value: object) -> bool:
    return value is None or (isinstance(value, Mapping | int | float) and not isinstance(value, bool))
