"""Comparison of two runs over one recording, most often with given and with estimated poses."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.comparison.against_truth import (
    EvaluatedRun,
    PosedTruth,
    compare_trajectories,
    degenerate_note,
    differences,
    evaluate_run,
    open_posed_truth,
)
from app.comparison.map_alignment import MapAlignment, align_maps
from app.comparison.matched_instances import Matching, match_instances
from app.console.waiting import waiting_for
from app.run_folder.mapped_run import MappedRun, moved_poses, read_run
from app.run_folder.world_frame import map_origin
from data_tools.recordings.local_origin import Origin
from razer.arrays import FloatArray
from razer.geometry import inverse
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.preset import Preset
from razer.metrics.protocol import scene_aggregation
from razer.metrics.protocol.evaluation import plain_json
from razer.metrics.protocol.scene_overlap import SceneOverlap, is_of_another_scene
from razer.metrics.scene_pair import TimedPoses
from razer.metrics.surface.surface_distance import TriangleSurface
from razer.metrics.surface.surface_errors import metrics_of_distances
from razer.metrics.trajectory_errors import PoseErrors, TrajectoryMetrics, errors_over_time
from razer.plugins import NO_TRUST, Trust

Numbers = dict[str, Any]


@dataclass(frozen=True)
class Comparison:
    """Run A, and run B in the frame of A, brought there by `alignment`.

    pose: B's trajectory against A's, and errors: of B's poses over time, None where either has no trajectory.
    surface: B's against A's, None where either is empty; a_to_b_m (V,): how far each vertex of A is from B's surface,
    metres, infinite where that is empty. truth_a, truth_b and truth_trajectory, that in the frame of A:
    None without a truth. notes: what one should know of the result. warnings: what makes it doubtful."""

    preset: str
    a: MappedRun
    b: MappedRun
    alignment: MapAlignment
    pose: TrajectoryMetrics | None
    errors: PoseErrors | None
    surface: Numbers | None
    a_to_b_m: FloatArray
    instances: Matching
    truth_a: EvaluatedRun | None
    truth_b: EvaluatedRun | None
    truth_trajectory: TimedPoses | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    def as_json(self) -> Numbers:
        """The machine-readable contract: plain JSON values only, null where a part does not apply or is no number."""
        a, b = (None if side is None else side.as_json() for side in (self.truth_a, self.truth_b))
        compared = {"format": 1, "run_a": self.a.name, "run_b": self.b.name, "preset": self.preset}
        sides = self._sides()
        results = {
            "a": a,
            "b": b,
            "delta": None if a is None or b is None else differences(_metrics(a), _metrics(b)),
            "frames": {side: None if run.account is None else run.account.as_json() for side, run in sides},
            "alignment": self.alignment.as_json(),
            "pose": self._pose(),
            "surface": self.surface,
            "instances": self.instances.as_json(),
            "notes": self.notes,
            "warnings": self.warnings,
        }
        corrected = {side: run.corrections.as_json() for side, run in sides if run.corrections is not None}
        return plain_json(compared | results | ({"corrected": corrected} if corrected else {}))

    def _sides(self) -> tuple[tuple[str, MappedRun], ...]:
        return ("a", self.a), ("b", self.b)

    def _pose(self) -> Numbers | None:
        numbers = self.pose
        if numbers is None:
            return None
        sides = {"truth_from_a": self.truth_a, "truth_from_b": self.truth_b}
        return {
            "ate_rmse_m": numbers.ate_rmse_m,
            "rotation_rmse_deg": numbers.rotation_rmse_deg,
            "rpe_trans_m": numbers.per_frame.translation_m,
            "rpe_rot_deg": numbers.per_frame.rotation_deg,
            "rpe_second_trans_m": numbers.per_second.translation_m,
            "rpe_second_rot_deg": numbers.per_second.rotation_deg,
            "compared": numbers.compared,
            "tracked_a": self.a.tracked,
            "tracked_b": self.b.tracked,
            "a_from_b": self.alignment.a_from_b.tolist(),
            "a_from_b_by_positions": numbers.by_positions.target_from_source.tolist(),
            "aligned_by": numbers.by_positions.basis,
            "degenerate": numbers.by_positions.degenerate,
        } | {key: None if side is None else side.pose.truth_from_estimate.tolist() for key, side in sides.items()}


def _metrics(evaluation: Numbers) -> Numbers:
    """The metrics of an evaluation, without its rules and without what is named after the run."""
    return {key: value for key, value in evaluation.items() if key not in ("preset", "settings", "scenes")}


def compare_runs(
    folder_a: Path, folder_b: Path, truth: Path | None, preset: Preset, trust: Trust = NO_TRUST
) -> Comparison:
    """Compare two runs, and each with the truth where one is given.

    B is aligned to A, and each to the truth, by the full poses of their trajectories; B is then refined on the surface
    of A. The absolute trajectory error has an alignment of its own, by positions (Umeyama). Saved maps have no
    trajectory: they are compared as they lie.

    Args:
        folder_a: the run folder to compare with.
        folder_b: the other run folder.
        truth: the folder with the truth and its camera poses, or None.
        preset: the rules of the evaluations against the truth.
        trust: which outside code may be loaded for the runs' embedders.

    Raises:
        BadInput: naming the folder that cannot be read or aligned.
    """
    with waiting_for("opening both maps"):
        a, b = (_seen_from(map_origin(folder_a), folder) for folder in (folder_a, folder_b))
    with waiting_for("aligning the maps"):
        pose, errors = _aligned(a, b, folder_a, folder_b)
        alignment = align_maps(a, b, pose)
    moved = b if alignment.basis == "none" else b.moved(alignment.a_from_b)
    with waiting_for("measuring how far their surfaces are apart"):
        surface, a_to_b_m = compare_surfaces(a.panoptic.mesh, moved.panoptic.mesh)
    with waiting_for("reading the truth"):
        scene = None if truth is None else open_posed_truth(truth, preset, map_origin(folder_a))
    with waiting_for("evaluating both runs against the truth"):
        runs = ((folder_a, a), (folder_b, b))
        truth_a, truth_b = (None if scene is None else evaluate_run(*run, scene, preset, trust) for run in runs)
    with waiting_for("matching their instances"):
        instances = match_instances(a.panoptic, moved.panoptic)
    return Comparison(
        preset=preset.name,
        a=a,
        b=moved,
        alignment=alignment,
        pose=pose,
        errors=errors,
        surface=surface,
        a_to_b_m=a_to_b_m,
        instances=instances,
        truth_a=truth_a,
        truth_b=truth_b,
        truth_trajectory=None if scene is None or truth_a is None else _true_trajectory(scene, truth_a),
        notes=(*_notes(a, b, pose, truth_a, truth_b), *(scene.notes if scene else ())),
        warnings=_place_warnings(surface, instances),
    )


def _seen_from(origin: Origin, folder: Path) -> MappedRun:
    """A run, whose map may have an origin of its own, in the frame of a map with another one."""
    run, own = read_run(folder), map_origin(folder)
    if own == origin:
        return run
    target_from_own = np.eye(4)
    target_from_own[:3, 3] = np.subtract(own, origin)
    return run.moved(target_from_own)


def _aligned(
    a: MappedRun, b: MappedRun, folder_a: Path, folder_b: Path
) -> tuple[TrajectoryMetrics | None, PoseErrors | None]:
    """B's trajectory against A's, where both have one."""
    if a.trajectory is None or b.trajectory is None:
        return None, None
    pose = compare_trajectories(a.trajectory, b.trajectory, str(folder_a), str(folder_b))
    return pose, errors_over_time(a.trajectory, b.trajectory, pose)


def _true_trajectory(truth: PosedTruth, run: EvaluatedRun) -> TimedPoses:
    """The true trajectory in the frame of a run."""
    return moved_poses(inverse(run.pose.truth_from_estimate), truth.trajectory)


def compare_surfaces(reference: LabelledMesh, other: LabelledMesh) -> tuple[Numbers | None, FloatArray]:
    """Distances of the other surface to the reference (accuracy) and of the reference to it (completeness), metres, and
    F-scores, None where either is empty; and the distance (V,) of each vertex of the reference to the other."""
    to_other = TriangleSurface(other.vertices, other.triangles).distances(reference.vertices)
    if not len(reference.vertices) or not len(other.vertices):
        return None, to_other
    to_reference = TriangleSurface(reference.vertices, reference.triangles).distances(other.vertices)
    numbers = scene_aggregation.surface([metrics_of_distances(to_reference, to_other)]) or {}
    return {key: value for key, value in numbers.items() if key != "on_truth"}, to_other


def _place_warnings(surface: Numbers | None, instances: Matching) -> tuple[str, ...]:
    """Whether the maps are of different places, by the rule that tells a map from the truth of another scene."""
    if surface is None:
        return ()
    overlap = SceneOverlap(surface["precision_5cm"], surface["recall_5cm"])
    n_fewer = len(instances.matched) + min(len(instances.missed), len(instances.extra))
    if not is_of_another_scene(overlap, len(instances.matched), n_fewer):
        return ()
    shared = f"{max(overlap):.0%} of a surface and {len(instances.matched)} of {n_fewer} instances in common"
    return (f"A and B may be of different places ({shared}): if they are of one recording, one of them drifted apart",)


def _notes(
    a: MappedRun,
    b: MappedRun,
    pose: TrajectoryMetrics | None,
    truth_a: EvaluatedRun | None,
    truth_b: EvaluatedRun | None,
) -> list[str]:
    """Caveats of the comparison."""
    alignments = {} if pose is None else {"B to A": pose}
    if truth_a and truth_b:
        alignments |= {"A to the truth": truth_a.pose, "B to the truth": truth_b.pose}
    notes = [
        degenerate_note(which, numbers.by_positions)
        for which, numbers in alignments.items()
        if numbers.by_positions.degenerate is not None
    ]
    if pose is None:
        notes.append("a map without trajectory.txt cannot be aligned: A and B are compared as they lie")
    for side, run in (("A", a), ("B", b)):
        if surfaceless := [o.id for o in run.panoptic.objects if not o.n_vertices]:
            ids = " ".join(map(str, surfaceless))
            notes.append(f"{side}: instances without a surface are left out: {ids}")
        if not len(run.panoptic.mesh.vertices):
            notes.append(f"{side}: the map is empty")
    return notes
