"""Writer of submissions to the ScanNet benchmark: a list of mask files with a class and a confidence each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from data_tools.predictions.mask_file import mask_text
from razer.arrays import BoolArray, IntArray

MASKS = "predicted_masks"


def write_submission(
    folder: Path,
    scene: str,
    masks: Mapping[int, IntArray],
    labels: Mapping[int, int],
    scores: Mapping[int, float],
    n_vertices: int,
) -> int:
    """Write folder/scene.txt, last of all, and the masks it lists; returns their number. Files of the same scene that
    are there are replaced; confidences can be read back to the last bit.

    Args:
        folder: where to; it is made if need be.
        scene: the name of the list.
        masks: vertex numbers (M,) by id, in the order in which they are listed; empty ones are left out.
        labels: class number by id, 0 where there is none, which the benchmark leaves out.
        scores: confidence by id, 1 where there is none.
        n_vertices: vertices of the mesh.
    """
    (folder / MASKS).mkdir(parents=True, exist_ok=True)
    lines: list[str] = []
    for number, mask in masks.items():
        if not len(mask):
            continue
        name = f"{MASKS}/{scene}_{len(lines):03d}.txt"
        (folder / name).write_bytes(mask_text(_inside(mask, n_vertices)))
        lines.append(f"{name} {labels.get(number, 0)} {float(scores.get(number, 1.0))!r}\n")
    (folder / f"{scene}.txt").write_text("".join(lines))
    return len(lines)


def _inside(mask: IntArray, n_vertices: int) -> BoolArray:
    inside = np.zeros(n_vertices, np.bool_)
    inside[mask] = True
    return inside
