"""Masks of everything in sight, or of what a detector boxed, from a SAM model in ONNX format."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.frame import BadInput, Frame, Masks
from razer.models import Segmenter, make_segmenter
from razer.models.mask_boxes import mask_boxes
from razer.models.mask_filters import best_of_overlapping, stability
from razer.models.model_file import model_file
from razer.models.onnx_graph import Device, OnnxGraph
from razer.models.sam_decoder import SamDecoder
from razer.models.sam_encoder import SamEncoder
from razer.models.sam_files import encoder_and_decoder


class SamSegmenter:
    """Exports of SAM and SAM 2 in two files: MobileSAM, EdgeSAM, SAM 2.1, SlimSAM and their kin.

    weights: a name of the catalogue, a folder with both files, or the encoder, with `decoder` the other file. points:
    prompts along the longer side of the image, each giving up to three masks. More: smaller things are found, and the
    time grows with the square. min_quality: least quality that the model expects of a mask. min_stability: least
    stability against the threshold. Lower: more masks, with worse borders. most_iou: overlap above which the lesser of
    two masks is dropped. Higher: one thing has several masks. batch: prompts at a time. boxes: instead of at points,
    masks are sought in the boxes around the masks of this segmenter, made with boxes_options; they take its names and
    scores. device: auto, cpu or cuda. Raises BadInput.
    """

    def __init__(
        self,
        weights: str | Path,
        decoder: str | Path | None = None,
        points: int = 16,
        min_quality: float = 0.8,
        min_stability: float = 0.9,
        most_iou: float = 0.7,
        batch: int = 64,
        boxes: str | None = None,
        boxes_options: Mapping[str, Any] | None = None,
        device: Device = "auto",
    ) -> None:
        shares = (min_quality, min_stability, most_iou)
        if points < 1 or batch < 1 or not all(0 <= share <= 1 for share in shares):
            raise BadInput(
                "the sam segmenter takes points and batch from 1, and quality, stability and IoU from 0 to 1"
            )
        self.n_points, self.min_quality, self.min_stability, self.most_iou = points, *shares
        weights = model_file(weights)
        files = (weights, model_file(decoder)) if decoder else encoder_and_decoder(weights)
        self.encoder = SamEncoder(OnnxGraph(files[0], device))
        self.decoder = SamDecoder(OnnxGraph(files[1], device), self.encoder.graph.outputs, batch)
        self.detector: Segmenter | None = make_segmenter(boxes, boxes_options or {}) if boxes else None

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; they may overlap. With `boxes`, in its order, else best first."""
        if self.detector is not None:
            return self._in_boxes(frame, self.detector.segment(frame))
        logits, quality = self._proposals(frame)
        order = best_of_overlapping(logits > 0, quality * stability(logits), self.most_iou)
        return Masks(_at_full_size(logits[order], frame.depth.shape), quality[order].clip(0, 1))

    def _proposals(self, frame: Frame) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Logits (N, h, w) of what is good and stable enough, and the quality expected of each."""
        features, view = self.encoder.encode(frame.rgb)
        grid = point_grid(frame.intrinsics.height, frame.intrinsics.width, self.n_points)
        logits: list[NDArray[np.float32]] = []
        quality: list[NDArray[np.float32]] = []
        for found, scores in self.decoder.at_points(features, view, grid):
            good = scores >= self.min_quality
            candidates, their_scores = found[good], scores[good]
            stable = stability(candidates) >= self.min_stability
            logits.append(candidates[stable])
            quality.append(their_scores[stable])
        return np.concatenate(logits), np.concatenate(quality)

    def _in_boxes(self, frame: Frame, detected: Masks) -> Masks:
        if not len(detected):
            return detected
        features, view = self.encoder.encode(frame.rgb)
        best: list[NDArray[np.float32]] = []
        for found, scores in self.decoder.in_boxes(features, view, mask_boxes(detected.masks)):
            best.append(found[np.arange(len(found)), scores.argmax(axis=1)])
        masks = _at_full_size(np.concatenate(best), frame.depth.shape)
        return Masks(masks, detected.scores, detected.class_names)


def point_grid(height: int, width: int, n: int) -> NDArray[np.float64]:
    """Centres (N, 2), x before y, of about square cells, n of them along the longer side of an image."""
    size = max(height, width) / n
    columns, rows = max(1, round(width / size)), max(1, round(height / size))
    x, y = (np.arange(columns) + 0.5) * width / columns, (np.arange(rows) + 0.5) * height / rows
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _at_full_size(logits: NDArray[np.float32], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Masks (N, H, W) of the image's shape (H, W) from logits (N, h, w)."""
    masks = np.empty((len(logits), *shape), bool)
    for mask, each in zip(masks, logits, strict=True):
        mask[:] = cv2.resize(each, shape[::-1], interpolation=cv2.INTER_LINEAR) > 0
    return masks
