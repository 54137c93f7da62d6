"""What a batch that is done took, from its report: where simulations get their times."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.batch.report import FORMAT
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import read_json


@dataclass(frozen=True)
class MeasuredBatch:
    """Seconds (N,) of each scene's successful attempt, and of the whole batch."""

    scene_s: Float64Array
    total_s: float

    @classmethod
    def read(cls, report: Path) -> MeasuredBatch:
        """From a report.json; raises BadInput where it is none, or no scene is done."""
        found = read_json(report)
        try:
            if found["format"] != FORMAT:
                raise BadInput(f"{report} is no report of a batch")
            done = [one["history"][-1]["seconds"] for one in found["scenes"] if one["status"] == "done"]
            total_s = float(found["totals"]["seconds"])
            scene_s = np.array(done, np.float64)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise BadInput(f"{report} is no report of a batch") from error
        if len(scene_s) == 0 or scene_s.min() <= 0:
            raise BadInput(f"{report}: no scene of it is done")
        return cls(scene_s, total_s)

    def drawn(self, n_scenes: int | None, seed: int) -> Float64Array:
        """Seconds of so many scenes (N,), each as long as one of those measured; None: of those themselves."""
        if n_scenes is None:
            return self.scene_s
        return np.random.default_rng(seed).choice(self.scene_s, n_scenes)
