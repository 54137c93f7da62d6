"""Text questions to finished runs: of each class that a map holds, and of names of what is not there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.ablation.matched_run import MatchedRun
from razer.models.oracle.profiles.confusable_classes import GROUP_OF
from razer.query.ranking import PRESENT

N_ABSENT = 60
SAME_NAME = 0.99  # cosine from which on two names mean the same


def measure_questions(runs: Sequence[MatchedRun], seed: int = 0) -> dict[str, float]:
    """Over all runs: `top1`, the share of classes in a map for which the best answer is one of them; precision and
    recall of saying that something of a name is there at all. Not there are names that the embedder's table has and no
    true class means: some at random, and what the classes are taken for."""
    best, is_there, is_right = [], [], []
    for run in runs:
        here = {*run.true_names.values()}
        for name in (*sorted(here), *_absent(run, seed)):
            hit = run.panoptic.query(name, threshold=0.0).hits[0]
            best.append(hit.score)
            is_there.append(name in here)
            is_right.append(run.true_names.get(hit.object.id) == name)
    said, there = np.array(best) >= PRESENT, np.array(is_there)
    return {
        "n_there": int(there.sum()),
        "n_absent": int((~there).sum()),
        "top1": float(np.array(is_right)[there].mean()),
        "present_precision": float(there[said].mean()) if said.any() else 1.0,
        "present_recall": float(said[there].mean()),
    }


def _absent(run: MatchedRun, seed: int) -> list[str]:
    queries = run.panoptic.text_queries
    assert queries is not None
    true = run.panoptic.text_vectors(run.names)
    known = [*dict.fromkeys([*queries.choices.names, *(name for name in sorted(GROUP_OF) if queries.knows(name))])]
    is_other = (run.panoptic.text_vectors(known) @ true.T).max(axis=1) < SAME_NAME
    others = [name for name, other in zip(known, is_other, strict=True) if other]
    confusable = [name for name in others if name in GROUP_OF]
    rest = [name for name in others if name not in GROUP_OF]
    drawn = np.random.default_rng(seed).choice(len(rest), min(N_ABSENT, len(rest)), replace=False)
    return [*(rest[i] for i in sorted(drawn.tolist())), *confusable]
