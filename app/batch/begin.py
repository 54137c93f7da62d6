"""The beginning of a batch: what its runs are asked for, and what an earlier one to the same place left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from app.batch.estimate import Estimator
from app.batch.one_scene import SceneTask
from app.batch.report import BatchReport, begun_report
from app.batch.run_batch import Batch, maps_there
from app.batch.scenes import Scene
from app.engines.engine import Engine
from app.engines.task import Needs
from app.object_store.place import Place
from app.settings.options import RunOptions
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.files import read_text
from razer.metrics.presets import PRESETS

_CPUS = 2.0  # three processes, which wait for each other, keep as many busy


@dataclass(frozen=True)
class BatchPlan:
    """What is done with each scene. words, config: options of `razer run`, and the content of its --config file;
    cores: to how many each run is held, 0 = to none; cpus, gpus: what it asks for."""

    words: tuple[str, ...]
    config: str | None
    settings: RunConfig
    cores: int
    cpus: float
    gpus: float
    truth_preset: str = ""

    @classmethod
    def of(
        cls, options: RunOptions, vocabulary: str | None, cores: int = 0, gpus: float | None = None, preset: str = ""
    ) -> BatchPlan:
        """The plan that options lead to; raises BadInput for those that fit one recording, or none."""
        if isinstance(options.poses, Path) or options.poses_from is not None:
            raise BadInput("a batch has many recordings, and a file poses one: leave --poses FILE and --poses-from out")
        if options.poses == "both":
            raise BadInput("--poses both means two runs: make a batch with --poses given, and one with slam")
        if preset and preset not in PRESETS:
            raise BadInput(f"--eval {preset}: choose from {', '.join(PRESETS)}")
        settings = options.read()
        config = None if options.config is None else read_text(options.config)
        words = run_words(replace(options, config=None))
        words += () if vocabulary is None else (f"--vocabulary={_vocabulary(vocabulary)}",)
        asked = float(settings.run.device == "cuda") if gpus is None else gpus
        return cls(words, config, settings, cores, float(cores or _CPUS), asked, preset)

    def as_json(self) -> dict[str, Any]:
        """What decides the results."""
        return {"options": list(self.words), "config": self.config}

    @property
    def template(self) -> SceneTask:
        """The task of any scene."""
        here = str(Path.cwd())
        needs = Needs(self.cpus, 0.0, self.gpus)
        return SceneTask(
            "", "", "", self.words, needs, here, self.config, cores=self.cores, truth_preset=self.truth_preset
        )


def run_words(options: RunOptions) -> tuple[str, ...]:
    """All options that were given, as `razer run` takes them."""
    words: list[str] = []
    for field in fields(options):
        value, option = getattr(options, field.name), f"--{field.name.replace('_', '-')}"
        if field.name == "set":
            words += [f"--set={text}" for text in value]
        elif value is True:
            words.append(option)
        elif value is False and field.default is None:
            words.append(f"--no-{option[2:]}")
        elif value not in (None, False):
            words.append(f"{option}={value}")
    return tuple(words)


def begin(
    scenes: list[Scene],
    out: Place,
    plan: BatchPlan,
    make_engine: Callable[[], Engine],
    console: Console,
    *,
    resume: bool,
) -> tuple[Batch, BatchReport]:
    """A batch that is ready to run, and its report; raises BadInput where the place is taken.

    Args:
        scenes: by name.
        out: where run folders and report go.
        plan: what is done with each.
        make_engine: makes the engine, once everything else is known to be right.
        console: where progress is shown.
        resume: go on with a batch that is there.
    """
    report = begun_report(out, plan.as_json(), maps_there(scenes, out), resume=resume)
    estimator = Estimator(plan.settings.voxels.voxel_size_m, plan.cpus, plan.gpus, learns_cpus=not plan.cores)
    return Batch(scenes, plan.template, plan.settings, make_engine(), estimator, report, console), report


def _vocabulary(name: str) -> str:
    return str(Path(name).absolute()) if Path(name).exists() else name
