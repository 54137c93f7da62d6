"""Evaluation of one scene in a process of its own, where it was mapped; afterwards the results of all become one.

python -m app.batch.scene_evaluation NAME RUN RECORDING PRESET RESULT [--trust-plugins]
"""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Mapping
from pathlib import Path

from app.object_store.place import Place
from app.object_store.publishing import write_text
from app.run_folder.run_folder import METRICS
from data_tools.truth.open_truth import has_truth
from razer.errors import BadInput
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation, pooled
from razer.plugins import FULL_TRUST, NO_TRUST

EVALUATION = "evaluation.json"


def main() -> None:
    """Evaluate; exit code 2 and a line for what cannot be evaluated."""
    name, run, recording, preset, result, *trust = sys.argv[1:]
    try:
        if not has_truth(Path(recording)):
            raise BadInput("the recording has no truth")
        from app.evaluation.evaluate_run import scene_result

        found = scene_result(
            (name, Path(run), Path(recording)), PRESETS[preset], trust=FULL_TRUST if trust else NO_TRUST
        )
    except BadInput as error:
        print(f"razer: {error}", file=sys.stderr)
        sys.exit(2)
    Path(result).write_bytes(pickle.dumps(found))


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


if __name__ == "__main__":
    main()
