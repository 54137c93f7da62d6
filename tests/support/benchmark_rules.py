"""ScanNet's instance benchmark, rule after rule and vertex after vertex: slow, and in nothing like the evaluator.

Truth is one number per vertex, label * 1000 + instance + 1; predictions are (mask (V,) bool, label, confidence).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

OVERLAPS = [*np.arange(0.5, 0.95, 0.05).tolist(), 0.25]
SMALLEST = 100

Prediction = tuple[np.ndarray, int, float]
BenchmarkScene = tuple[np.ndarray, list[Prediction]]


def truths_of(ids: np.ndarray, label: int) -> list[np.ndarray]:
    """The vertices of each truth of the label, in the order of their numbers."""
    return [ids == number for number in sorted(set(ids.tolist())) if number // 1000 == label]


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    both = int((a & b).sum())
    return both / (int(a.sum()) + int(b.sum()) - both)


def outcomes_of_class(
    ids: np.ndarray, predictions: list[Prediction], labels: list[int], label: int, threshold: float
) -> tuple[list[tuple[float, int]], int, bool, bool]:
    """(score, right or wrong) of what counts, misses, whether there is a truth and a prediction."""
    own = [(m, s) for m, predicted, s in predictions if predicted == label and int(m.sum()) >= SMALLEST]
    every_truth = truths_of(ids, label)
    truths = [t for t in every_truth if int(t.sum()) >= SMALLEST]
    counted: list[tuple[float, int]] = []
    visited: set[int] = set()
    misses = 0
    for truth in truths:
        score = None
        for index, (mask, confidence) in enumerate(own):
            if index in visited or not overlap(truth, mask) > threshold:
                continue
            if score is None:
                visited.add(index)
                score = confidence
            else:
                counted.append((min(score, confidence), 0))
                score = max(score, confidence)
        if score is None:
            misses += 1
        else:
            counted.append((score, 1))
    void = ~np.isin(ids // 1000, labels)
    for mask, confidence in own:
        if any(overlap(truth, mask) > threshold for truth in every_truth):
            continue
        ignored = int((void & mask).sum())
        ignored += sum(int((t & mask).sum()) for t in every_truth if int(t.sum()) < SMALLEST)
        if ignored / int(mask.sum()) <= threshold:
            counted.append((confidence, 0))
    return counted, misses, bool(truths), bool(own)


def area(counted: list[tuple[float, int]], misses: int) -> float:
    """Precision against recall at every distinct score, closed by (1, 0), with central differences of the recall."""
    points = []
    for threshold in sorted({score for score, _ in counted}):
        right = sum(r for score, r in counted if score >= threshold)
        wrong = sum(1 - r for score, r in counted if score >= threshold)
        lost = sum(r for score, r in counted if score < threshold) + misses
        points.append((right / (right + wrong), right / (right + lost)))
    points.append((1.0, 0.0))
    recall = [points[0][1], *(r for _, r in points), 0.0]
    return sum(p * (recall[i] - recall[i + 2]) / 2 for i, (p, _) in enumerate(points))


def benchmark(scenes: list[BenchmarkScene], labels: list[int]) -> dict[int, list[float]]:
    """The average precision of each label at each of OVERLAPS."""
    result: dict[int, list[float]] = {}
    for label in labels:
        result[label] = []
        for threshold in OVERLAPS:
            outcomes = [outcomes_of_class(ids, predictions, labels, label, threshold) for ids, predictions in scenes]
            counted = [one for part, _, _, _ in outcomes for one in part]
            misses = sum(part for _, part, _, _ in outcomes)
            if not any(truth for _, _, truth, _ in outcomes):
                result[label].append(math.nan)
            elif not any(predicted for _, _, _, predicted in outcomes) or not counted:
                result[label].append(0.0)
            else:
                result[label].append(area(counted, misses))
    return result


def averages(result: dict[int, list[float]]) -> tuple[float, float, float]:
    """AP, AP50 and AP25 as the benchmark prints them."""
    table = np.array(list(result.values()))
    return float(np.nanmean(table[:, :9])), float(np.nanmean(table[:, 0])), float(np.nanmean(table[:, 9]))


def listed_predictions(list_file: Path, labels: list[int]) -> list[Prediction]:
    """The predictions of a scene as the benchmark's script reads them: three words a line with one space between,
    files inside the folder, labels that are not evaluated passed over, a mask wherever the number is not 0."""
    predictions = []
    for line in list_file.read_text().splitlines():
        name, label, confidence = line.split(" ")
        assert not Path(name).is_absolute()
        assert list_file.parent.resolve() in (list_file.parent / name).resolve().parents
        if int(float(label)) in labels:
            numbers = np.array((list_file.parent / name).read_text().splitlines(), dtype=np.int64)
            predictions.append((np.not_equal(numbers, 0), int(float(label)), float(confidence)))
    return predictions
