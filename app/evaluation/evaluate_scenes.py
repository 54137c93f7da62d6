"""Evaluation of many scenes, several at once, whose results become one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from app.console.waiting import waiting_for
from app.engines.call_functions import NamedCall, call_functions
from app.engines.called_function import Call
from app.engines.engine import Engine
from app.engines.task import Needs
from app.evaluation.evaluate_run import Job, Reading, evaluate_job
from razer.metrics.preset import Preset
from razer.metrics.protocol.evaluation import Evaluation, pooled

_BASE_MB = 1200.0  # of a process with the libraries it needs; what scenes take is learnt


def evaluate_scenes(
    jobs: Sequence[Job],
    preset: Preset,
    reading: Reading,
    make_engine: Callable[[], Engine],
    console: Console,
    *,
    notes: list[str],
) -> Evaluation:
    """Evaluate scenes.

    Args:
        jobs: (name, prediction, folder with the truth) of each scene.
        preset: the rules.
        reading: how predictions are read.
        make_engine: makes what many scenes are evaluated by; one alone is evaluated here.
        console: where progress is shown.
        notes: what the evaluations remark is added to it.

    Raises:
        BadInput: naming the prediction that does not fit its truth.
    """
    if len(jobs) == 1:
        with waiting_for("evaluating against the truth", console):
            evaluated = [evaluate_job(jobs[0], preset, reading)]
    else:
        calls = [_call(job, preset, reading) for job in jobs]
        evaluated = list(call_functions(calls, make_engine(), console, things="scenes").values())
    for (name, _, _), one in zip(jobs, evaluated, strict=True):
        notes.extend(f"{name}: {note}" for note in one.notes)
    return pooled([one.result for one in evaluated], preset)


def _call(job: Job, preset: Preset, reading: Reading) -> NamedCall:
    name, prediction, _ = job
    return NamedCall(name, Call(evaluate_job, (job, preset, reading)), Needs(1.0, _BASE_MB), float(_bytes(prediction)))


def _bytes(prediction: Path) -> int:
    """By what the longest comes first."""
    files = prediction.iterdir() if prediction.is_dir() else [prediction]
    return sum(file.stat().st_size for file in files if file.is_file())
