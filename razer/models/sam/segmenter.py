"""Masks of everything in sight, or of what a detector boxed, from a model of SAM's family."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import Segmenter, make_segmenter
from razer.models.mask_boxes import mask_boxes
from razer.models.runtime.device import Device
from razer.models.sam.mask_proposals import ProposalLimits, masks_in_boxes, masks_of_everything
from razer.models.sam.open_model import sam_model


class SamSegmenter:
    """SAM and SAM 2 and their kin: exports in two ONNX files (MobileSAM, EdgeSAM, SAM 2.1, SlimSAM), or checkpoints
    of the `transformers` library.

    weights: a name of the catalogue, a folder with both files or with a checkpoint, or the encoder's file, with
    `decoder` the other. batch: prompts at a time. boxes: instead of at points, masks are sought in the boxes around the
    masks of this segmenter, an object or a name with boxes_options; they take its names and scores. device: auto, cpu
    or cuda. limits: the options of ProposalLimits. Raises BadInput.
    """

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
            return Masks(*masks_of_everything(self.model, frame.rgb, self.limits))
        found = self.detector.segment(frame)
        found = found.select(np.flatnonzero(found.masks.any(axis=(1, 2))))  # what covers nothing has no box
        return Masks(masks_in_boxes(self.model, frame.rgb, mask_boxes(found.masks)), found.scores, found.class_names)
