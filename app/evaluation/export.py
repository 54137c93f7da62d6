"""Export of evaluated predictions in the files that benchmarks and other systems' evaluations read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from data_tools.predictions.submission_writer import write_submission
from data_tools.predictions.vertex_labels_writer import write_label_texts, write_labelled_mesh
from razer.arrays import Int64Array
from razer.errors import BadInput
from razer.metrics.preset import Preset
from razer.metrics.protocol.scene_labels import SceneLabels, labels_on_truth
from razer.metrics.protocol.scene_result import in_frame_of_truth
from razer.metrics.protocol.vertex_masks import VertexMasks
from razer.metrics.scene_pair import PredictedScene, TruthScene

ExportFormat = Literal["scannet", "replica", "labels"]


@dataclass(frozen=True, slots=True)
class Export:
    """Where predictions go, and as what: scannet, a submission to the ScanNet benchmark; replica, texts with the class
    and the instance of each vertex, and confidences; labels, a mesh with the three. scene: what the files are called;
    None = as the scene is."""

    format: ExportFormat
    folder: Path
    scene: str | None = None

    def write(self, name: str, truth: TruthScene, predicted: PredictedScene, preset: Preset) -> str:
        """Write one scene as the evaluation takes it, its instances carried to the truth's vertices, classes and
        confidences by the preset's rules; returns in words what was written. Raises BadInput where the prediction has
        no instances, or overlapping masks that a label a vertex cannot hold."""
        scene = self.scene or name
        whole = replace(truth, evaluated=None)
        labels = labels_on_truth(whole, in_frame_of_truth(truth, predicted), preset)
        if labels.predicted_instances is None:
            raise BadInput(f"--export {self.format}: the prediction of {scene} has classes alone, and no instances")
        masks = _masks(labels.predicted_instances)
        of_class = labels.predicted_instance_classes
        if self.format == "scannet":
            n_vertices = len(truth.vertices)
            count = write_submission(self.folder, scene, masks, of_class, labels.scores, n_vertices)
            return f"{self.folder / scene}.txt lists {count} masks"
        instances = _single(labels, scene, self.format)
        if self.format == "labels":
            path = self.folder / f"{scene}.ply"
            write_labelled_mesh(path, truth.vertices, truth.triangles, instances, of_class, labels.scores)
            return f"{path} holds {len(masks)} instances"
        classes = np.zeros_like(instances) if labels.predicted_classes is None else labels.predicted_classes
        write_label_texts(self.folder, scene, instances, classes, of_class, labels.scores)
        return f"{self.folder / scene}.txt and the files beside it hold {len(masks)} instances"


def _masks(instances: Int64Array | VertexMasks) -> VertexMasks | dict[int, Int64Array]:
    """The vertex numbers of each instance, by increasing id."""
    if isinstance(instances, VertexMasks):
        return instances
    order = np.argsort(instances, kind="stable")
    ids, first = np.unique(instances[order], return_index=True)
    parts = np.split(order, first[1:])
    return {i: part for i, part in zip(ids.tolist(), parts, strict=True) if i > 0}


def _single(labels: SceneLabels, scene: str, wanted: ExportFormat) -> Int64Array:
    """One instance for each vertex; raises BadInput where masks overlap."""
    instances, single = labels.predicted_instances, labels.single_instances
    if isinstance(instances, VertexMasks) and sum(map(len, instances.values())) > np.count_nonzero(single):
        raise BadInput(f"--export {wanted}: masks of {scene} overlap, which a label a vertex cannot hold: take scannet")
    return single
