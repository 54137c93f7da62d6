"""Open-vocabulary segmentation by text-prompted models: SAM 3, or a detector with a SAM."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from razer.arrays import BoolArray, Float32Array, IndexArray, Uint8Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.mask_filters import best_of_overlapping
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.sam.mask_proposals import masks_in_boxes
from razer.models.sam.open_model import sam_model
from razer.models.sam.promptable import Promptable
from razer.models.text_prompted.box_detector import PHRASE_KINDS, SENTENCE_KINDS, PhraseDetector
from razer.models.text_prompted.prompts import prompt_phrases
from razer.models.text_prompted.sam3 import SAM3_KINDS, Sam3Detector

_OVERLAP_STRIDE = 4  # pixels; overlaps are measured on every fourth


class PromptedSegmenter:
    """SAM 3 alone, or Grounding DINO or OWLv2, whose boxes a model of SAM's family turns into masks.

    Args:
        weights: a checkpoint of the `transformers` library, by folder, name of the catalogue or hub id.
        words: what to segment: a list, a text with commas, or a vocabulary by name or file.
        mask_weights: the SAM that a detector needs, in ONNX format or as a checkpoint.
        confidence: lowest score; OWLv2 scores lower than the others and needs about 0.15. Lower: more objects, and more
            false ones.
        most_iou: overlap above which the worse of two masks is dropped.
        batch: boxes at a time.
        device: auto, cpu or cuda.

    Raises:
        BadInput: for impossible options, or where there is no such model.
    """

    looks_at_color_alone = True

    def __init__(
        self,
        weights: str | Path,
        words: str | Sequence[str],
        mask_weights: str | Path | None = None,
        confidence: float = 0.3,
        most_iou: float = 0.7,
        batch: int = 16,
        device: Device = "auto",
    ) -> None:
        if not (0 <= confidence <= 1 and 0 <= most_iou <= 1 and batch >= 1):
            raise BadInput("segmenter options: confidence and most_iou are from 0 to 1, and batch is at least 1")
        checkpoint, self.words, self.most_iou = Checkpoint.of(weights), prompt_phrases(words), most_iou
        self.masks: Sam3Detector | None = None
        if checkpoint.kind in SAM3_KINDS:
            self.masks = Sam3Detector(checkpoint, self.words, confidence, device)
            return
        if checkpoint.kind not in SENTENCE_KINDS | PHRASE_KINDS:
            raise BadInput(
                f"{checkpoint.folder} holds '{checkpoint.kind}': prompted takes SAM 3, Grounding DINO and OWLv2"
            )
        if mask_weights is None:
            raise BadInput(f"{checkpoint.kind} finds boxes: set option mask_weights to a SAM, such as mobile-sam")
        self.detector = PhraseDetector(checkpoint, self.words, confidence, device)
        self.sam: Promptable = sam_model(mask_weights, None, batch, device)

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, best first, with the words as class names; they may overlap a little."""
        masks, scores, phrases = self._detections(frame.rgb)
        order = best_of_overlapping(masks[:, ::_OVERLAP_STRIDE, ::_OVERLAP_STRIDE], scores, self.most_iou)
        return Masks(masks[order], scores[order].clip(0, 1), tuple(self.words[phrases[i]] for i in order))

    def _detections(self, rgb: Uint8Array) -> tuple[BoolArray, Float32Array, IndexArray]:
        if self.masks is not None:
            return self.masks.detect(rgb)
        boxes = self.detector.detect(rgb)
        return masks_in_boxes(self.sam, rgb, boxes.boxes), boxes.scores, boxes.phrases
