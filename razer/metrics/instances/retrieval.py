"""Top-1 retrieval: whether a mask is given the class that it has (protocol D)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from razer.metrics.instances.instance_ap import nanmean
from razer.metrics.instances.matching import Overlaps


@dataclass(frozen=True, slots=True)
class RetrievalCounts:
    """By class name: masks that were asked for, and those that were given the right class."""

    asked: Counter[str]
    right: Counter[str]

    @classmethod
    def of(cls, answers: Iterable[tuple[str, bool]]) -> RetrievalCounts:
        """Count (class, whether right) of masks."""
        answers = list(answers)
        return cls(Counter(name for name, _ in answers), Counter(name for name, right in answers if right))

    def __add__(self, other: RetrievalCounts) -> RetrievalCounts:
        return RetrievalCounts(self.asked + other.asked, self.right + other.right)

    @property
    def per_class(self) -> dict[str, float]:
        """Share of the right ones by class."""
        return {name: self.right[name] / count for name, count in sorted(self.asked.items())}

    @property
    def class_mean(self) -> float:
        """Mean of the classes' shares; nan without any."""
        return nanmean(self.per_class.values())

    @property
    def instance_mean(self) -> float:
        """Share of the right ones of all; nan without any."""
        return self.right.total() / self.asked.total() if self.asked else float("nan")


def classes_given(truth: Mapping[int, str], given: Mapping[int, str]) -> RetrievalCounts:
    """(i) The truth's own masks: the class of each true instance, the mode of its vertices' classes, and that given."""
    return RetrievalCounts.of((name, given.get(number) == name) for number, name in truth.items())


def classes_of_partners(
    overlaps: Overlaps,
    truth: Mapping[int, str],
    predicted: Mapping[int, str],
    min_iou: float = 0.25,
    missed_is_wrong: bool = True,
) -> RetrievalCounts:
    """(ii) Predicted masks: each true instance with a class is asked for the class of the predicted instance of the
    largest intersection over union, the lowest id of equal ones, which must exceed min_iou."""
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
