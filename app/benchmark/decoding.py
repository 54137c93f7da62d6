"""Benchmark of YOLO mask decoding: from the outputs of a segmentation model to masks, the model itself left out."""

from __future__ import annotations

import cv2
import numpy as np

from app.benchmark.repeated_timing import median_ms
from razer.arrays import BoolArray, Float32Array
from razer.models.yolo.decoder import YoloDecoder
from razer.models.yolo.letterbox import Letterbox

_MASKS, _CLASSES, _PROTOTYPES, _ANCHORS = 30, 80, 32, 8400
_IMAGE, _INPUT, _GRID = (480, 640), (640, 640), (160, 160)


def measure_decoding() -> dict[str, float]:
    """Milliseconds, median of 30 rounds, from outputs as of YOLOv8 to 30 masks of 640x480; and how that compares with
    no more than enlarging 30 whole masks."""
    predictions, prototypes = _outputs()
    decoder = YoloDecoder("bench", tuple(map(str, range(_CLASSES))), 0.25, 0.7, 100)
    letterbox = Letterbox.of(_IMAGE, _INPUT)
    n_masks = len(decoder.masks(predictions, prototypes, letterbox))
    decoding_ms = median_ms(lambda: decoder.masks(predictions, prototypes, letterbox))
    enlarging_ms = median_ms(lambda: _enlarge(prototypes[0, :_MASKS]))
    return {"masks": n_masks, "median_ms": round(decoding_ms, 2), "to_enlarging": round(decoding_ms / enlarging_ms, 2)}


def _outputs() -> tuple[Float32Array, Float32Array]:
    """Predictions in which 30 things stand out, each found by six anchors, and smooth prototypes."""
    rng = np.random.default_rng(0)
    predictions = rng.uniform(0, 0.1, (1, 4 + _CLASSES + _PROTOTYPES, _ANCHORS)).astype(np.float32)
    for thing in range(_MASKS):
        anchors = rng.choice(_ANCHORS, 6, replace=False)
        predictions[0, :2, anchors] = rng.uniform([100, 150], [540, 490])
        predictions[0, 2:4, anchors] = rng.uniform(60, 300, 2)
        predictions[0, 4 + thing, anchors] = rng.uniform(0.3, 0.9, 6)
    predictions[0, -_PROTOTYPES:] = rng.normal(0, 1, (_PROTOTYPES, _ANCHORS))
    noise = rng.normal(0, 1, (_PROTOTYPES, *_GRID)).astype(np.float32)
    return predictions, np.stack([cv2.GaussianBlur(layer, (0, 0), 6) for layer in noise])[None]


def _enlarge(masks: Float32Array) -> list[BoolArray]:
    return [cv2.resize(mask, _INPUT) > 0 for mask in masks]
