"""Evaluation of runs in the frame of the ground truth, each aligned by its trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.evaluation.evaluate_run import true_poses, truth_for, truth_scene, with_map
from app.evaluation.frame_accounts import with_accounts
from app.evaluation.prediction import read_prediction
from app.run_folder.mapped_run import MappedRun
from data_tools.recordings.local_origin import HERE, Origin
from razer.errors import BadInput
from razer.metrics.preset import Preset
from razer.metrics.protocol.evaluation import Evaluation, evaluate
from razer.metrics.scene_pair import TimedPoses, TruthScene
from razer.metrics.trajectory_errors import PoseErrors, TrajectoryMetrics, errors_over_time, trajectory_metrics
from razer.metrics.umeyama import PoseAlignment
from razer.plugins import NO_TRUST, Trust

MIN_COMMON_POSES = 3


@dataclass(frozen=True)
class PosedTruth:
    """Ground truth of a scene with the true trajectory in its frame."""

    scene: TruthScene
    trajectory: TimedPoses
    notes: tuple[str, ...]


@dataclass(frozen=True)
class EvaluatedRun:
    """Evaluation of the run in a folder, aligned to the truth: metrics, alignment, and pose errors over time."""

    folder: Path
    evaluation: Evaluation
    pose: TrajectoryMetrics
    errors: PoseErrors

    def as_json(self) -> dict[str, Any]:
        """What `razer eval --json` says of the run."""
        return with_accounts(self.evaluation.as_json(), [(name, self.folder) for name in self.evaluation.scenes])


def open_posed_truth(folder: Path, preset: Preset, origin: Origin = HERE) -> PosedTruth:
    """The truth in a folder, as seen from an origin; raises BadInput where it holds none, or no camera poses in its
    frame."""
    truth = truth_for(folder, preset)
    trajectory = true_poses(folder)
    if trajectory is None:
        raise BadInput(f"{folder} has no camera poses to align the runs by: give the recording's folder, or no --truth")
    scene = truth_scene(truth, trajectory, origin)
    assert scene.trajectory is not None
    return PosedTruth(scene, scene.trajectory, tuple(truth.notes))


def evaluate_run(
    folder: Path, run: MappedRun, truth: PosedTruth, preset: Preset, trust: Trust = NO_TRUST
) -> EvaluatedRun:
    """Evaluate a run in the frame of the truth.

    Args:
        folder: the run folder.
        run: its content, in its own frame.
        truth: the ground truth with its trajectory.
        preset: the rules.
        trust: which outside code may be loaded for the run's embedder.

    Raises:
        BadInput: if run and truth have fewer than MIN_COMMON_POSES stamps in common.
    """
    if run.trajectory is None:
        raise BadInput(f"{folder} has no trajectory.txt to align it to the truth by: use `razer eval`, or no --truth")
    pose = compare_trajectories(truth.trajectory, run.trajectory, "the truth", str(folder))
    scene = truth.scene
    n_vertices, template = len(scene.vertices), preset.text_template
    predicted = read_prediction(folder, scene.class_names, n_vertices, template=template, trust=trust)
    predicted = with_map(replace(predicted, own_frame=True), folder, scene, preset)
    evaluation = evaluate([(run.name, scene, predicted)], preset)
    return EvaluatedRun(folder, evaluation, pose, errors_over_time(truth.trajectory, run.trajectory, pose))


def compare_trajectories(
    reference: TimedPoses, estimate: TimedPoses, reference_name: str, estimate_name: str
) -> TrajectoryMetrics:
    """Errors of one trajectory against another after alignment, and the motions that align them.

    Args:
        reference: the trajectory to compare with.
        estimate: the other one.
        reference_name: what messages call the reference.
        estimate_name: what messages call the estimate.

    Raises:
        BadInput: if they have fewer than MIN_COMMON_POSES stamps in common.
    """
    numbers = trajectory_metrics(reference, estimate)
    n_common = 0 if numbers is None else numbers.compared
    if numbers is None or n_common < MIN_COMMON_POSES:
        raise BadInput(
            f"{estimate_name} and {reference_name} have {n_common} stamps in common, {MIN_COMMON_POSES} are needed: "
            "are they of one recording?"
        )
    return numbers


def degenerate_note(which: str, alignment: PoseAlignment) -> str:
    """What one should know of an absolute trajectory error whose positions do not fix its alignment."""
    helped = ", so that orientations helped" if alignment.basis == "orientations" else ""
    return f"{which}: the alignment by positions, on which ATE stands, is degenerate: {alignment.degenerate}{helped}"


def differences(a: Mapping, b: Mapping) -> dict[str, object]:
    """b - a for each number that two results of one shape have, None where either has none; what is no
    number and holds none is left out."""
    return {key: _difference(a[key], b[key]) for key in a if key in b and _is_numeric(a[key]) and _is_numeric(b[key])}


def _difference(a: object, b: object) -> object:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return differences(a, b)
    return b - a if isinstance(a, int | float) and isinstance(b, int | float) else None


def _is_numeric(value: object) -> bool:
    return value is None or (isinstance(value, Mapping | int | float) and not isinstance(value, bool))
