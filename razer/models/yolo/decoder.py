"""Decoding of YOLO segmentation outputs: layouts, non-maximum suppression, masks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array, Int64Array
from razer.errors import BadInput
from razer.frame import Masks
from razer.models.yolo.letterbox import Letterbox
from razer.models.yolo.prototype_masks import prototype_masks

Layout = Literal["dense", "end to end"]


@dataclass(frozen=True)
class Candidates:
    """N candidate detections: boxes (N, 4) x1, y1, x2, y2 in pixels of the input, scores (N,), classes (N,), and mask
    coefficients (N, M)."""

    boxes: Float32Array
    scores: Float32Array
    classes: Int64Array
    coefficients: Float32Array

    def select(self, rows: NDArray) -> Candidates:
        """Those at the given rows, in their order."""
        return Candidates(self.boxes[rows], self.scores[rows], self.classes[rows], self.coefficients[rows])


@dataclass(frozen=True)
class YoloDecoder:
    """Masks from a model's outputs. source names the model in messages; class_names is None where the file has none;
    the rest is as in YoloSegmenter."""

    source: str
    class_names: tuple[str, ...] | None
    confidence: float
    iou: float
    max_masks: int

    def layout(self, rows: int, columns: int, n_prototypes: int) -> Layout:
        """How predictions (1, rows, columns) are laid out; raises BadInput.

        Dense: (4 + classes + M, anchors), centres and sizes, of YOLOv8, YOLO11, YOLOE and FastSAM. End to end:
        (N, 6 + M), corners, score and class, of YOLO26, YOLOv10 and exports with NMS inside.
        """
        if columns == 6 + n_prototypes:
            return "end to end"
        n_classes = rows - 4 - n_prototypes
        if n_classes >= 1 and (self.class_names is None or n_classes == len(self.class_names)):
            return "dense"
        named = "C" if self.class_names is None else len(self.class_names)
        raise BadInput(
            f"{self.source}: predictions of {rows}x{columns} fit no YOLO layout: expected 4 + {named} classes + "
            f"{n_prototypes} rows, or 6 + {n_prototypes} columns"
        )

    def masks(self, predictions: Float32Array, prototypes: Float32Array, letterbox: Letterbox) -> Masks:
        """Masks at the size of the image, best first, from predictions (1, rows, columns) and prototypes
        (1, M, h, w); raises BadInput."""
        _, rows, columns = predictions.shape
        if self.layout(rows, columns, prototypes.shape[1]) == "dense":
            candidates = decode_dense(predictions[0], prototypes.shape[1], self.confidence)
            candidates = non_maximum_suppression(candidates, self.iou)
        else:
            candidates = decode_end_to_end(predictions[0], self.confidence)
        candidates = candidates.select(np.argsort(-candidates.scores, kind="stable")[: self.max_masks])
        pixels = prototype_masks(candidates.coefficients, prototypes[0], candidates.boxes, letterbox)
        has_pixels = np.array([mask.any() for mask in pixels], np.bool_)
        masks = Masks(pixels, candidates.scores.clip(0, 1), self._names(candidates.classes))
        return masks if has_pixels.all() else masks.select(has_pixels)

    def _names(self, classes: Int64Array) -> tuple[str, ...] | None:
        if self.class_names is None:
            return None
        if len(classes) and not 0 <= classes.min() <= classes.max() < len(self.class_names):
            raise BadInput(f"{self.source}: predicts class {classes.max()}, but names {len(self.class_names)} classes")
        return tuple(self.class_names[number] for number in classes)


def decode_dense(predictions: Float32Array, n_prototypes: int, confidence: float) -> Candidates:
    """The candidates in predictions (4 + classes + M, anchors) with at least this confidence."""
    end = len(predictions) - n_prototypes
    best = predictions[4:end].max(axis=0)
    rows = predictions[:, best >= confidence].T
    centers, halves = rows[:, :2], rows[:, 2:4] / 2
    boxes = np.concatenate([centers - halves, centers + halves], axis=1)
    return Candidates(boxes, best[best >= confidence], rows[:, 4:end].argmax(axis=1), rows[:, end:])


def decode_end_to_end(predictions: Float32Array, confidence: float) -> Candidates:
    """The candidates in predictions (N, 6 + M) with at least this confidence."""
    rows = predictions[predictions[:, 4] >= confidence]
    return Candidates(rows[:, :4], rows[:, 4], rows[:, 5].astype(np.int64), rows[:, 6:])


def non_maximum_suppression(candidates: Candidates, iou: float) -> Candidates:
    """The candidates, best first, without those that overlap a better one of their class by more than `iou`."""
    order = np.argsort(-candidates.scores, kind="stable")
    kept: list[int] = []
    while len(order):
        first, order = int(order[0]), order[1:]
        kept.append(first)
        overlaps = box_iou_2d(candidates.boxes[first], candidates.boxes[order]) > iou
        order = order[~(overlaps & (candidates.classes[order] == candidates.classes[first]))]
    return candidates.select(np.array(kept, np.int64))


def box_iou_2d(box: Float32Array, others: Float32Array) -> Float32Array:
    """Intersection over union (N,) of a box (4,) x1, y1, x2, y2 with each of (N, 4)."""
    sides = np.minimum(box[2:], others[:, 2:]) - np.maximum(box[:2], others[:, :2])
    shared: Float32Array = sides.clip(0).prod(axis=1)
    area, areas = (box[2:] - box[:2]).prod(), (others[:, 2:] - others[:, :2]).prod(axis=1)
    return shared / np.maximum(area + areas - shared, 1e-9)
