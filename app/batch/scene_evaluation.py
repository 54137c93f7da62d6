"""Evaluation of one scene where it was mapped; afterwards the results of all become one."""

from __future__ import annotations

import json
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from app.console.streams import print_notes
from app.object_store.place import Place
from app.object_store.publishing import write_text
from app.run_folder.run_folder import METRICS
from razer.errors import BadInput
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation, pooled
from razer.plugins import FULL_TRUST, NO_TRUST

if TYPE_CHECKING:
    from razer.metrics.protocol.scene_result import SceneResult

EVALUATION = "evaluation.json"


def evaluated_scene(name: str, run: str, recording: str, preset: str, trusts: bool) -> SceneResult:
    """The evaluation of the map of a scene.

    Args:
        name: of the scene.
        run: its run folder.
        recording: the folder with the truth.
        preset: by whose rules.
        trusts: whether the run's embedder may be code that is not part of the project.

    Raises:
        BadInput: where there is no truth, or it does not fit.
    """
    from app.evaluation.evaluate_run import Reading, evaluate_job  # late, since it brings Open3D along
    from data_tools.truth.open_truth import has_truth

    if not has_truth(Path(recording)):
        raise BadInput("the recording has no truth")
    reading = Reading(trust=FULL_TRUST if trusts else NO_TRUST)
    evaluated = evaluate_job((name, Path(run), Path(recording)), PRESETS[preset], reading)
    print_notes(evaluated.notes)
    return evaluated.result


def pool(evaluations: Mapping[str, bytes], preset: str, out: Place) -> Evaluation:
    """The metrics over all scenes, written to evaluation.json; those of each go to the metrics.json of its run.

    Args:
        evaluations: pickled results of the scenes by name; they come from our own processes.
        preset: by whose rules.
        out: where the batch went.
    """
    result = pooled([pickle.loads(evaluations[name]) for name in sorted(evaluations)], PRESETS[preset])
    content = result.as_json()
    write_text(out / EVALUATION, json.dumps(content, indent=1) + "\n")
    for name, numbers in content["scenes"].items():
        write_text(out / name / METRICS, json.dumps(numbers, indent=1) + "\n")
    return result
