"""Class-agnostic segmentation by SAM: of the whole image, or in the boxes of a detector."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import Segmenter, make_segmenter
from razer.models.mask_boxes import mask_boxes
from razer.models.runtime.device import Device
from razer.models.sam.mask_proposals import ProposalLimits, automatic_masks, masks_in_boxes
from razer.models.sam.open_model import sam_model


class SamSegmenter:
    """SAM, SAM 2 and similar models: exports in two ONNX files (MobileSAM, EdgeSAM, SAM 2.1, SlimSAM), or checkpoints
    of the `transformers` library.

    Args:
        weights: a name of the catalogue, a folder with both files or with a checkpoint, or the encoder's file.
        decoder: the decoder's file where `weights` is the encoder's.
        batch: prompts at a time.
        boxes: a segmenter, by name or as an object: instead of at a grid of points, masks are made in the boxes around
            its masks, and take its class names and scores.
        boxes_options: options of that segmenter, where it is given by name.
        device: auto, cpu or cuda.
        limits: the options of ProposalLimits.

    Raises:
        BadInput: for impossible options, or where there is no such model.
    """

    looks_at_color_alone = True

    def __init__(
        self,
        weights: str | Path,
        decoder: str | Path | None = None,
        batch: int = 64,
        boxes: str | Segmenter | None = None,
        boxes_options: Mapping[str, Any] | None = None,
        device: Device = "auto",
        **limits: Any,
    ) -> None:
        if batch < 1:
            raise BadInput(f"segmenter option batch is at least 1, not {batch}")
        self.limits = ProposalLimits(**limits)
        self.detector = make_segmenter(boxes, boxes_options or {}) if isinstance(boxes, str) else boxes
        self.model = sam_model(weights, decoder, batch, device)

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; they may overlap. With `boxes`, in its order, else best first."""
        if self.detector is None:
            return Masks(*automatic_masks(self.model, frame.rgb, self.limits))
        detections = self.detector.segment(frame)
        detections = detections.select(np.flatnonzero(detections.masks.any(axis=(1, 2))))  # an empty mask has no box
        masks = masks_in_boxes(self.model, frame.rgb, mask_boxes(detections.masks))
        return replace(detections, masks=masks)
