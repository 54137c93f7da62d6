"""One run, or another system's prediction, beside the truth."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from app.evaluation.prediction import Meaning, Naming, read_prediction
from app.run_folder.timed_poses import timed_poses
from data_tools.open_sequence import open_sequence
from data_tools.recordings.file_sequence import FileSequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import open_truth
from razer.errors import BadInput, UnusableFrame
from razer.metrics.class_table import FROM_TRUTH
from razer.metrics.presets import Preset
from razer.metrics.protocol.evaluation import Evaluation, Pair, evaluate
from razer.metrics.scene_pair import TimedPoses, TruthScene
from razer.plugins import NO_TRUST, Trust

Job = tuple[str, Path, Path]


def evaluate_jobs(
    jobs: Iterable[Job],
    preset: Preset,
    *,
    naming: Naming = "auto",
    scene: str | None = None,
    labels: Meaning = "instance",
    trust: Trust = NO_TRUST,
    notes: list[str],
) -> Evaluation:
    """Evaluate (name, prediction, folder with the truth) one after the other; what readers had to say is added to
    notes. Raises BadInput naming the prediction that does not fit its truth."""
    current = ""

    def pairs() -> Iterator[Pair]:
        nonlocal current
        for name, prediction, truth_folder in jobs:
            current = f"{prediction} does not fit {truth_folder}"
            truth = truth_for(truth_folder, preset, scene)
            notes.extend(f"{name}: {note}" for note in truth.notes)
            predicted = read_prediction(
                prediction,
                truth.class_names,
                len(truth.vertices),
                naming=naming,
                template=preset.text_template,
                scene=scene,
                labels=labels,
                trust=trust,
            )
            yield name, truth_scene(truth, true_poses(truth_folder)), predicted

    try:
        return evaluate(pairs(), preset)
    except BadInput:
        raise
    except ValueError as error:
        raise BadInput(f"{current}: {error}") from error


def truth_for(folder: Path, preset: Preset, scene: str | None = None) -> GroundTruth:
    """The truth in a folder, in the classes of a preset; raises BadInput."""
    asked = None if preset.vocabulary == FROM_TRUTH else preset.vocabulary
    return open_truth(folder, vocabulary=asked, scene=scene)


def truth_scene(truth: GroundTruth, trajectory: TimedPoses | None = None) -> TruthScene:
    """A ground truth as the evaluator takes it; surfaces that no frame saw do not count."""
    return TruthScene(
        truth.vertices,
        truth.instances,
        truth.classes,
        truth.class_names,
        triangles=truth.triangles,
        evaluated=truth.visible.astype(np.bool_),
        trajectory=trajectory,
    )


def true_poses(folder: Path) -> TimedPoses | None:
    """The poses of the recording that a truth belongs to: in the folder or, of a folder `truth`, around it."""
    for place in (folder, folder.absolute().parent) if folder.absolute().name == "truth" else (folder,):
        if (place / "trajectory.txt").is_file():
            return timed_poses(place / "trajectory.txt")
        try:
            sequence = open_sequence(place)
        except BadInput:
            continue
        if isinstance(sequence, FileSequence) and sequence.pose_of is not None:
            return _poses_of(sequence)
    return None


def _poses_of(sequence: FileSequence) -> TimedPoses | None:
    assert sequence.pose_of is not None
    found = {}
    for index, shot in enumerate(sequence.shots):
        try:
            found[shot.stamp] = sequence.pose_of(index)[0]
        except UnusableFrame:
            continue
    stamps = sorted(found)
    return TimedPoses(np.array(stamps), np.stack([found[s] for s in stamps]), len(sequence)) if stamps else None
