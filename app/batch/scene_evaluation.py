"""Evaluation of one scene in a process of its own, where it was mapped; results of all scenes are pooled afterwards.

python -m app.batch.scene_evaluation NAME RUN RECORDING PRESET RESULT [--trust-plugins]
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path

from data_tools.truth.open_truth import has_truth
from razer.errors import BadInput
from razer.metrics.presets import PRESETS
from razer.plugins import FULL_TRUST, NO_TRUST


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


if __name__ == "__main__":
    main()
