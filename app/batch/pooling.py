"""Evaluations of scenes, made where these were mapped, become one."""

from __future__ import annotations

import json
import pickle
from collections.abc import Mapping

from app.object_store.place import Place
from app.object_store.publishing import write_text
from app.run_folder.run_folder import METRICS
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation, pooled

EVALUATION = "evaluation.json"


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
