"""Runs over the scenes of a table, and what they come to."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from app.commands.measure.eval import METRICS, write_atomically
from app.evaluation.evaluate_run import evaluate_jobs
from app.frames.open_recording import open_recording, open_unchecked
from app.pipeline.run_pipeline import resolve_poses, run_to_folder
from app.reproduction.published_tables import PublishedTable
from app.run_folder import run_folder as names
from app.run_folder.run_folder import RunFolder
from app.settings.config_file import read_config
from app.settings.options import RunOptions
from app.settings.run_config import RunConfig
from data_tools.truth.open_truth import has_truth
from razer.errors import BadInput
from razer.metrics.presets import PRESETS, Preset
from razer.metrics.protocol.evaluation import Evaluation
from razer.storage.map_folder import is_map_folder

Row = tuple[float | None, ...]


@dataclass(frozen=True)
class Reproduced:
    """Our row of the table, the evaluation behind it, seconds by scene, median milliseconds by stage, and the scenes
    that failed or are not there, with the reason."""

    row: Row
    evaluation: Evaluation
    seconds: Mapping[str, float]
    stages_ms: Mapping[str, float]
    failed: Mapping[str, str]

    def as_json(self, table: str) -> dict[str, Any]:
        """Everything as plain JSON values."""
        return {
            "table": table,
            "row": list(self.row),
            "seconds": dict(self.seconds),
            "stages_ms": dict(self.stages_ms),
            "failed": dict(self.failed),
            "evaluation": self.evaluation.as_json(),
        }


class Reproduction:
    """The scenes of a table in a folder of data, and where their runs go. Raises BadInput where there is none."""

    def __init__(
        self, table: PublishedTable, data: Path, out: Path, options: RunOptions, scenes: Sequence[str]
    ) -> None:
        self._table = table
        self._out = out
        self._preset = PRESETS[table.preset]
        self._config = _mapping_config(self._preset, options)
        if not data.is_dir():
            raise BadInput(f"{data} is not a folder: give the folder with the scenes")
        asked = tuple(scenes) or table.scenes or tuple(p.name for p in sorted(data.iterdir()) if p.is_dir())
        self._places = {name: place for name in asked if (place := _place_of(data, name)) and has_truth(place)}
        self._absent = {name: f"not found in {data} with a truth" for name in asked if name not in self._places}
        if not self._places:
            raise BadInput(f"{data} holds none of the scenes {', '.join(asked[:4])} ... with a truth")
        if not scenes and not table.scenes:
            self._absent = {}  # not every folder needs to be a scene

    def run(self, console: Console) -> Reproduced:
        """Map what is not mapped yet, then evaluate all scenes together."""
        failed = dict(self._absent)
        for number, (name, place) in enumerate(self._places.items(), start=1):
            console.print(f"{name}: scene {number} of {len(self._places)}")
            try:
                self._map(name, place, console)
            except BadInput as error:
                failed[name] = str(error)
                console.print(f"{name} is left out: {error}", soft_wrap=True)
        done = {name: place for name, place in self._places.items() if name not in failed}
        if not done:
            raise BadInput(f"no scene could be mapped; the first problem: {next(iter(failed.values()))}")
        return self._evaluated(done, failed, console)

    def _map(self, name: str, place: Path, console: Console) -> None:
        folder = self._out / name
        config = resolve_poses(self._config, open_unchecked(place, self._config.input))
        if is_map_folder(folder) and read_config(folder / names.CONFIG, (), {}) == config:
            console.print("  mapped already with these settings")
            return
        target = RunFolder(folder, overwrite=True)
        finished = run_to_folder(open_recording(place, config.input, console), config, target, console)
        if finished.accounting.interrupted:
            raise KeyboardInterrupt

    def _evaluated(self, done: Mapping[str, Path], failed: Mapping[str, str], console: Console) -> Reproduced:
        notes: list[str] = []
        jobs = [(name, self._out / name, place) for name, place in done.items()]
        result = evaluate_jobs(jobs, self._preset, trust=self._config.embedder.trust, notes=notes)
        for note in notes:
            console.print(f"note: {note}", soft_wrap=True)
        for name, numbers in result.as_json()["scenes"].items():
            write_atomically(self._out / name / METRICS, json.dumps(numbers, indent=1) + "\n")
        timings = {name: json.loads((self._out / name / names.TIMINGS).read_text()) for name in done}
        seconds = {name: round(float(t["wall_s"]), 2) for name, t in timings.items()}
        stages = {stage for t in timings.values() for stage in t["stages"]}
        stages_ms = {
            stage: round(float(np.mean([t["stages"][stage]["median_ms"] for t in timings.values()])), 2)
            for stage in sorted(stages)
        }
        return Reproduced(_our_row(self._table, result, seconds), result, seconds, stages_ms, failed)


def _mapping_config(preset: Preset, options: RunOptions) -> RunConfig:
    """The settings of a run: the preset's for its maps, and over them whatever the user gave."""
    hints = {
        "voxels.voxel_size_m": preset.voxel_size_m,
        "voxels.truncation_voxels": preset.truncation_voxels,
        "voxels.depth_max_m": preset.depth_max_m,
        "input.stride": preset.every if preset.every > 1 else None,
    }
    hinted = [f"{name}={value}" for name, value in hints.items() if value is not None]
    return read_config(options.config, (*hinted, *options.set), options.flags(), trust=options.trust)


def _place_of(data: Path, name: str) -> Path | None:
    """The folder of a scene: Replica's room0 is also called room_0."""
    spaced = name.rstrip("0123456789")
    other = f"{spaced}_{name[len(spaced) :]}"
    return next((data / each for each in (name, other) if (data / each).is_dir()), None)


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
    retrieval = (result.retrieval or {}).get("predicted_masks") or {}
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
    }


def _percent(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else 100 * value
