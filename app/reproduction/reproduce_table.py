"""Reproduction of one of the paper's tables: a batch of its scenes, mapped and evaluated, and the row they give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from app.batch.begin import BatchPlan, begin
from app.batch.scene_evaluation import pool
from app.batch.scenes import Scene
from app.engines.engine_options import PlacingOptions
from app.object_store.place import Place
from app.reproduction.component_times import component_times
from app.reproduction.published_tables import PublishedTable
from app.run_folder.run_folder import TIMINGS
from app.settings.options import RunOptions
from data_tools.truth.open_truth import has_truth
from razer.errors import BadInput
from razer.files import read_json
from razer.metrics.preset import Preset
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation

Row = tuple[float | None, ...]


@dataclass(frozen=True)
class Reproduced:
    """Our row of the table, the evaluation behind it, seconds by scene, median milliseconds by stage, mean milliseconds
    a frame by component, and the scenes that failed or are not there, with the reason."""

    row: Row
    evaluation: Evaluation
    seconds: Mapping[str, float]
    stages_ms: Mapping[str, float]
    components_ms: Mapping[str, float]
    failed: Mapping[str, str]

    @property
    def retrieval(self) -> dict[str, dict[str, float | None]]:
        """Top-1 by class mean and by instance mean in %, of the predicted masks and of the truth's; none where nothing
        has a class."""
        by_masks = self.evaluation.retrieval or {}
        return {
            name: {key: _percent(numbers[key]) for key in ("class_mean", "instance_mean")}
            for name in ("predicted_masks", "given_masks")
            if (numbers := by_masks.get(name))
        }

    def as_json(self, table: str) -> dict[str, Any]:
        """Everything as plain JSON values."""
        return {
            "table": table,
            "row": list(self.row),
            "seconds": dict(self.seconds),
            "stages_ms": dict(self.stages_ms),
            "components_ms": dict(self.components_ms),
            "retrieval": self.retrieval,
            "failed": dict(self.failed),
            "evaluation": self.evaluation.as_json(),
        }


class Reproduction:
    """The scenes of a table in a folder of data, and where their runs go."""

    def __init__(
        self, table: PublishedTable, data: Path, out: Path, options: RunOptions, scenes: Sequence[str]
    ) -> None:
        """Find the scenes.

        Args:
            table: the table to reproduce.
            data: the folder with the scenes, each with its truth.
            out: the folder for a run folder a scene, and the report of the batch that they are.
            options: settings of the runs; they override the preset's.
            scenes: names of other scenes than the table's.

        Raises:
            BadInput: if `data` holds none of the scenes with a truth, or a setting is wrong.
        """
        self._table, self._out = table, out
        self._options = _with_preset(PRESETS[table.preset], options)
        if not data.is_dir():
            raise BadInput(f"{data} is not a folder: give the folder with the scenes")
        scene_names = tuple(scenes) or table.scenes or tuple(p.name for p in sorted(data.iterdir()) if p.is_dir())
        folders = {name: _scene_folder(data, name) for name in scene_names}
        self._scene_folders = {name: folder for name, folder in folders.items() if folder and has_truth(folder)}
        missing = folders.keys() - self._scene_folders.keys()
        self._missing = {name: f"not found in {data} with a truth" for name in scene_names if name in missing}
        if not self._scene_folders:
            raise BadInput(f"{data} holds none of the scenes {', '.join(scene_names[:4])} ... with a truth")
        if not scenes and not table.scenes:
            self._missing = {}  # not every folder needs to be a scene

    def run(self, placing: PlacingOptions, console: Console) -> Reproduced:
        """Map and evaluate what is not mapped yet, and evaluate the rest again; then all scenes become one row."""
        plan = BatchPlan.of(self._options, None, placing.cores, placing.gpus, self._table.preset)
        scenes = [Scene(name, Place(str(folder.absolute()))) for name, folder in self._scene_folders.items()]
        batch, batch_report = begin(scenes, Place(str(self._out)), plan, placing.engine, console, resume=True)
        batch.run()
        reasons = {name: record.reason for name, record in batch_report.scenes.items() if record.status == "failed"}
        failed = {**self._missing, **reasons, **batch.not_evaluated}
        if not batch.evaluations:
            raise BadInput(f"no scene could be mapped; the first problem: {next(iter(failed.values()))}")
        result = pool(batch.evaluations, self._table.preset, Place(str(self._out)))
        return _reproduced(self._table, self._out, result, failed)


def _reproduced(table: PublishedTable, out: Path, result: Evaluation, failed: Mapping[str, str]) -> Reproduced:
    """Our row, and the times that the runs wrote down."""
    timings = {name: read_json(out / name / TIMINGS, only_finite=False) for name in result.scenes}
    seconds = {name: round(float(t["wall_s"]), 2) for name, t in timings.items()}
    stages = {stage for t in timings.values() for stage in t["stages"]}
    stages_ms = {
        stage: round(float(np.mean([t["stages"][stage]["median_ms"] for t in timings.values()])), 2)
        for stage in sorted(stages)
    }
    row, components_ms = _our_row(table, result, seconds), component_times(list(timings.values()))
    return Reproduced(row, result, seconds, stages_ms, components_ms, failed)


def _with_preset(preset: Preset, options: RunOptions) -> RunOptions:
    """The settings of the runs: the preset's, and over them whatever the user gave."""
    preset_settings = {
        "voxels.voxel_size_m": preset.voxel_size_m,
        "voxels.truncation_voxels": preset.truncation_voxels,
        "voxels.depth_max_m": preset.depth_max_m,
        "input.stride": preset.every if preset.every > 1 else None,
    }
    preset_assignments = [f"{name}={value}" for name, value in preset_settings.items() if value is not None]
    return replace(options, set=(*preset_assignments, *options.set))


def _scene_folder(data: Path, name: str) -> Path | None:
    """The folder of a scene: Replica's room0 is also called room_0."""
    room = name.rstrip("0123456789")
    other = f"{room}_{name[len(room) :]}"
    return next((data / candidate for candidate in (name, other) if (data / candidate).is_dir()), None)


def _our_row(table: PublishedTable, result: Evaluation, seconds: Mapping[str, float]) -> Row:
    """Our numbers in the units of the table's columns."""
    flat = _numbers(result)
    flat["s a scene"] = float(np.mean(list(seconds.values())))
    for name, numbers in result.scenes.items():
        flat[name] = _percent((numbers["class_aware"] or {}).get("ap50"))
    return tuple(flat.get(column) for column in table.columns)


def _numbers(result: Evaluation) -> dict[str, float | None]:
    aware, semantic = result.class_aware or {}, result.semantic or {}
    splits = aware.get("splits") or {}
    by_masks = result.retrieval or {}
    retrieval, of_truth = (by_masks.get(name) or {} for name in ("predicted_masks", "given_masks"))
    return {
        "mean": _percent(aware.get("ap50")),
        "AP": _percent(aware.get("ap")),
        "AP50": _percent(aware.get("ap50")),
        "AP25": _percent(aware.get("ap25")),
        **{name: _percent((splits.get(name) or {}).get("ap")) for name in ("head", "common", "tail")},
        "mIoU": semantic.get("miou"),
        "F-mIoU": semantic.get("fmiou"),
        "mAcc": semantic.get("macc"),
        "class mean": _percent(retrieval.get("class_mean")),
        "instance mean": _percent(retrieval.get("instance_mean")),
        "class mean, true masks": _percent(of_truth.get("class_mean")),
        "instance mean, true masks": _percent(of_truth.get("instance_mean")),
    }


def _percent(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else 100 * value
