"""Reproduction of one of the paper's tables: every scene mapped, then all evaluated together."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from app.console.streams import print_notes
from app.evaluation.evaluate_run import evaluate_jobs
from app.frames.open_recording import open_recording, open_unchecked
from app.pipeline.prepare_run import print_model_note, resolve_models, resolve_poses
from app.pipeline.run_pipeline import run_to_folder
from app.reproduction.component_times import component_times
from app.reproduction.published_tables import PublishedTable
from app.run_folder import run_folder as names
from app.run_folder.run_folder import RunFolder
from app.settings.config_file import read_config, read_run_config
from app.settings.options import RunOptions
from app.settings.run_config import RunConfig
from data_tools.truth.open_truth import has_truth
from razer.errors import BadInput
from razer.files import read_json
from razer.metrics.presets import PRESETS, Preset
from razer.metrics.protocol.evaluation import Evaluation
from razer.storage.atomic_files import replace_content
from razer.storage.file_names import is_map_folder

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
            out: the folder for a run folder a scene.
            options: settings of the runs; they override the preset's.
            scenes: names of other scenes than the table's.

        Raises:
            BadInput: if `data` holds none of the scenes with a truth, or a setting is wrong.
        """
        self._table = table
        self._out = out
        self._preset = PRESETS[table.preset]
        self._config = _mapping_config(self._preset, options)
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

    def run(self, console: Console) -> Reproduced:
        """Map what is not mapped yet, then evaluate all scenes together."""
        failed = dict(self._missing)
        self._config, note = resolve_models(self._config)
        print_model_note(note, console)
        for number, (name, scene_folder) in enumerate(self._scene_folders.items(), start=1):
            console.print(f"{name}: scene {number} of {len(self._scene_folders)}")
            try:
                self._map(name, scene_folder, console)
            except BadInput as error:
                failed[name] = str(error)
                console.print(f"{name} is left out: {error}", soft_wrap=True)
        mapped = {name: scene_folder for name, scene_folder in self._scene_folders.items() if name not in failed}
        if not mapped:
            raise BadInput(f"no scene could be mapped; the first problem: {next(iter(failed.values()))}")
        return self._evaluate(mapped, failed, console)

    def _map(self, name: str, scene_folder: Path, console: Console) -> None:
        folder = self._out / name
        config = resolve_poses(self._config, open_unchecked(scene_folder, self._config.input))
        if is_map_folder(folder) and read_run_config(folder / names.CONFIG) == config:
            console.print("  mapped already with these settings")
            return
        target = RunFolder(folder, overwrite=True)
        sequence = open_recording(scene_folder, config.input, console)
        finished = run_to_folder(sequence, config, target, console)
        if finished.accounting.interrupted:
            raise KeyboardInterrupt

    def _evaluate(self, mapped: Mapping[str, Path], failed: Mapping[str, str], console: Console) -> Reproduced:
        notes: list[str] = []
        jobs = [(name, self._out / name, scene_folder) for name, scene_folder in mapped.items()]
        result = evaluate_jobs(jobs, self._preset, trust=self._config.embedder.trust, notes=notes)
        print_notes(notes)
        for name, numbers in result.as_json()["scenes"].items():
            replace_content(self._out / name / names.METRICS, json.dumps(numbers, indent=1) + "\n")
        timings = {name: read_json(self._out / name / names.TIMINGS, only_finite=False) for name in mapped}
        seconds = {name: round(float(t["wall_s"]), 2) for name, t in timings.items()}
        stages = {stage for t in timings.values() for stage in t["stages"]}
        stages_ms = {
            stage: round(float(np.mean([t["stages"][stage]["median_ms"] for t in timings.values()])), 2)
            for stage in sorted(stages)
        }
        row, components_ms = _our_row(self._table, result, seconds), component_times(list(timings.values()))
        return Reproduced(row, result, seconds, stages_ms, components_ms, failed)


def _mapping_config(preset: Preset, options: RunOptions) -> RunConfig:
    """The settings of the runs: the preset's, and over them whatever the user gave."""
    preset_settings = {
        "voxels.voxel_size_m": preset.voxel_size_m,
        "voxels.truncation_voxels": preset.truncation_voxels,
        "voxels.depth_max_m": preset.depth_max_m,
        "input.stride": preset.every if preset.every > 1 else None,
    }
    preset_assignments = [f"{name}={value}" for name, value in preset_settings.items() if value is not None]
    assignments = (*preset_assignments, *options.set)
    return read_config(options.config, assignments, options.flags(), trust=options.trust, preset=options.preset)


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
