"""Ablation of the mapper: variants with one part changed, over the same frames of a synthetic recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import torch
from rich.table import Table

from app.ablation.perceived_walk import PerceivedWalk
from app.console.progress import show_progress
from app.console.streams import progress_console
from app.console.waiting import waiting_for
from app.settings.config_file import read_config
from app.settings.oracle_options import OracleOptions, oracle_options
from app.settings.presets import DEPARTURES, PAPER
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from data_tools.truth.ground_truth import GroundTruth
from razer.errors import BadInput
from razer.mapper import Mapper
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.surface.nearest_vertices import transfer_labels
from razer.models import make_embedder, make_segmenter
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import best_names

# The paper, then ours with one departure taken back alone, then ours with another part changed, and ours.
VARIANTS: dict[str, Mapping[str, Any]] = {
    "the paper": PAPER,
    **DEPARTURES,
    "association: box containment": {"association.geometry_distance": "containment"},
    "bank: one hypothesis": {"bank.hypotheses": 1},
    "as is": {},
}
FULL_NOISE = oracle_options("full")
COLUMNS = {
    "ap50": ("AP50", 3),
    "aware_ap50": ("AP50 by class", 3),
    "miou": ("mIoU", 3),
    "pq": ("PQ", 3),
    "duplicates_percent": ("duplicates %", 1),
    "missed": ("missed", 1),
    "judged_per_true": ("per true", 2),
}
"""Figures in the table: names and decimals. `per true` are the instances that are judged over the true ones."""
Row = dict[str, float]


def measure_variants(
    scene: str,
    seed: int,
    n_frames: int | None,
    variants: Mapping[str, Mapping[str, Any]],
    strides: Sequence[int] = (1,),
    options: OracleOptions = FULL_NOISE,
) -> dict[int, dict[str, Row]]:
    """The metrics of each variant on one synthetic scene, by stride: the walk is the same for all, of which every
    stride-th frame is mapped, and so is the truth, which is what all its frames see. The walk waits on disk, some 5 MB
    a frame, and one map is made after the other.

    Args:
        scene: name of the synthetic scene.
        seed: of scene and noise.
        n_frames: frames along the camera path; None: as many as a hand-held camera needs.
        variants: settings that differ from the defaults, by name of the variant.
        strides: of how many frames one is mapped.
        options: of the oracle segmenter and embedder; depth and colour have a Kinect's errors in any case.
    """
    torch.set_num_threads(1)
    console = progress_console()
    models = (
        make_segmenter("oracle", {**options[0], "seed": seed}),
        make_embedder("oracle", {**options[1], "seed": seed}),
    )
    with waiting_for("building the scene and its light", console):
        sequence = SyntheticScene(scene, seed, n_frames, sensor=SensorModel.kinect())
    indices = [i for i in range(len(sequence)) if any(i % stride == 0 for stride in strides)]
    rows: dict[int, dict[str, Row]] = {stride: {} for stride in strides}
    with TemporaryDirectory() as folder:
        walk = PerceivedWalk(Path(folder), models, read_config(None, (), {}))
        rendered = show_progress(indices, len(indices), lambda: f"seed {seed}: the walk", console)
        walk.record(sequence[index] for index in rendered)
        with waiting_for("computing which surfaces are visible", console):
            truth = sequence.truth()
        for name in show_progress(
            list(variants), len(variants), lambda: f"seed {seed}", console, first="the first variant", things="variants"
        ):
            config = read_config(None, (), variants[name])
            observations = walk.perceived(config)
            for stride in strides:
                mapper = Mapper(config, *models)
                for observation in observations:
                    if observation.frame.index % stride == 0:
                        mapper.fuse(observation)
                rows[stride][name] = _row(mapper, truth)
    return rows


def _row(mapper: Mapper, truth: GroundTruth) -> Row:
    mapper.finish()
    ground_truth = TruthScene(
        truth.vertices, truth.instances, truth.classes, truth.class_names, evaluated=truth.visible.astype(np.bool_)
    )
    predicted = _predicted(mapper.snapshot(), truth)
    result = evaluate([("scene", ground_truth, predicted)], PRESETS["default"]).as_json()
    if result["class_aware"] is None:
        raise BadInput("a map has no instance with a name: give more --frames")
    return {
        "ap50": result["class_agnostic"]["ap50"],
        "aware_ap50": result["class_aware"]["ap50"],
        "miou": result["semantic"]["miou"],
        "pq": result["panoptic"]["pq"],
        "duplicates_percent": 100 * result["duplicates"] / max(result["n_predicted"], 1),
        "missed": result["missed"],
        "instances": result["n_predicted"],
        "judged_per_true": result["n_judged"] / max(result["n_true"], 1),
    }


def _predicted(panoptic: PanopticMap, truth: GroundTruth) -> PredictedScene:
    """The instances, each named as `razer label` would among the truth's classes, on the truth's vertices: surface
    distances are not measured."""
    named = best_names(panoptic, sorted(set(truth.instance_classes.values())))
    labels = transfer_labels(panoptic.mesh.vertices, panoptic.mesh.instances, truth.vertices)
    return PredictedScene(instances=labels, scores={o.id: o.score for o in panoptic.objects}, class_names=named)


def variants_table(rows: list[dict[int, dict[str, Row]]], title: str) -> Table:
    """Means over the seeds, one line for each variant and stride."""
    result = Table(title=title, title_justify="left")
    result.add_column("variant")
    result.add_column("stride", justify="right")
    for name, _ in COLUMNS.values():
        result.add_column(name, justify="right")
    for variant, stride in ((variant, stride) for stride, first in rows[0].items() for variant in first):
        means = {column: float(np.mean([row[stride][variant][column] for row in rows])) for column in COLUMNS}
        result.add_row(variant, str(stride), *(f"{means[column]:.{n}f}" for column, (_, n) in COLUMNS.items()))
    return result
