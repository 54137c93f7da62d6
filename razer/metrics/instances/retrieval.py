"""Top-1 retrieval accuracy: whether a mask is given its true class (protocol D)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from razer.metrics.instances.instance_ap import nanmean
from razer.metrics.instances.matching import Overlaps


@dataclass(frozen=True, slots=True)
class RetrievalCounts:
    """By class name: masks that were queried, and those that were given the correct class."""

    asked: Counter[str]
    correct: Counter[str]

    @classmethod
    def of(cls, answers: Iterable[tuple[str, bool]]) -> RetrievalCounts:
        """Count (class, whether correct) of masks."""
        answers = list(answers)
        return cls(Counter(name for name, _ in answers), Counter(name for name, correct in answers if correct))

    def __add__(self, other: RetrievalCounts) -> RetrievalCounts:
        return RetrievalCounts(self.asked + other.asked, self.correct + other.correct)

    @property
    def per_class(self) -> dict[str, float]:
        """Share of correct ones by class."""
        return {name: self.correct[name] / count for name, count in sorted(self.asked.items())}

    @property
    def class_mean(self) -> float:
        """Mean of the classes' shares; nan without any."""
        return nanmean(self.per_class.values())

    @property
    def instance_mean(self) -> float:
        """Share of correct ones of all; nan without any."""
        return self.correct.total() / self.asked.total() if self.asked else float("nan")


def given_mask_retrieval(truth: Mapping[int, str], given: Mapping[int, str]) -> RetrievalCounts:
    """(i) The truth's own masks: the class of each true instance, most frequent among its vertices, and that given."""
    return RetrievalCounts.of((name, given.get(number) == name) for number, name in truth.items())


def predicted_mask_retrieval(
    overlaps: Overlaps,
    truth: Mapping[int, str],
    predicted: Mapping[int, str],
    min_iou: float = 0.25,
    missed_is_wrong: bool = True,
) -> RetrievalCounts:
    """(ii) Predicted masks: each true instance is given the class of the predicted instance that overlaps it most, the
    lowest id of equal ones.

    Args:
        overlaps: shared vertices of true and predicted instances.
        truth: class by true instance id; instances without one are left out.
        predicted: class by predicted instance id.
        min_iou: the intersection over union must exceed this.
        missed_is_wrong: whether a true instance that no prediction overlaps enough counts as wrong, or not at all.
    """
    answers = []
    iou = overlaps.iou
    for row, number in enumerate(overlaps.truth_ids.tolist()):
        if number not in truth:
            continue
        best = int(np.argmax(iou[row])) if len(overlaps.predicted_ids) else -1
        if best >= 0 and iou[row, best] > min_iou:
            answers.append((truth[number], predicted.get(int(overlaps.predicted_ids[best])) == truth[number]))
        elif missed_is_wrong:
            answers.append((truth[number], False))
    return RetrievalCounts.of(answers)
