"""The accounts of the runs' frames in the JSON of an evaluation."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from app.run_folder.timed_poses import run_poses


def with_accounts(content: dict[str, Any], predictions: Iterable[tuple[str, Path]]) -> dict[str, Any]:
    """An evaluation as JSON whose scenes also say what became of the run's frames, `frames`; null for what is no run.

    Args:
        content: of `Evaluation.as_json`.
        predictions: name and place of each scene's prediction.
    """
    scenes = {name: dict(numbers) for name, numbers in content["scenes"].items()}
    for name, place in predictions:
        own = run_poses(place)
        scenes[name]["frames"] = None if own is None else own[1].as_json()
    return content | {"scenes": scenes}
