"""Masks of what words name, from models that understand text."""

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
from razer.models.text_prompted import mask_grounding as word_masks
from razer.models.text_prompted.box_grounding import ONE_SENTENCE, WORD_BY_WORD, WordDetector
from razer.models.text_prompted.mask_grounding import WordMasks
from razer.models.text_prompted.prompts import asked_words

_SPARSE = 4  # overlaps are measured on every so many pixels


class PromptedSegmenter:
    """Things by name: SAM 3 alone, or Grounding DINO or OWLv2, whose boxes a model of SAM's family turns into masks.

    weights: a checkpoint of the `transformers` library, by folder, name of the catalogue or hub id. words: what to look
    for: a list, a text with commas, or a vocabulary by name or file. mask_weights: the SAM that a detector needs, in
    ONNX format or as a checkpoint. confidence: least score; OWLv2 is seldom as sure as the others, and wants about
    0.15. Lower: more things, and more that are none. most_iou: overlap above which the lesser of two masks is dropped.
    batch: boxes at a time. device: auto, cpu or cuda. Raises BadInput.
    """

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
        checkpoint, self.words, self.most_iou = Checkpoint.of(weights), asked_words(words), most_iou
        self.masks: WordMasks | None = None
        if checkpoint.kind in word_masks.KINDS:
            self.masks = WordMasks(checkpoint, self.words, confidence, device)
            return
        if checkpoint.kind not in ONE_SENTENCE | WORD_BY_WORD:
            raise BadInput(
                f"{checkpoint.folder} holds '{checkpoint.kind}': prompted takes SAM 3, Grounding DINO and OWLv2"
            )
        if mask_weights is None:
            raise BadInput(f"{checkpoint.kind} finds boxes: set option mask_weights to a SAM, such as mobile-sam")
        self.detector = WordDetector(checkpoint, self.words, confidence, device)
        self.sam: Promptable = sam_model(mask_weights, None, batch, device)

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, best first, with the words as class names; they may overlap a little."""
        masks, scores, words = self._found(frame.rgb)
        order = best_of_overlapping(masks[:, ::_SPARSE, ::_SPARSE], scores, self.most_iou)
        return Masks(masks[order], scores[order].clip(0, 1), tuple(self.words[words[i]] for i in order))

    def _found(self, rgb: Uint8Array) -> tuple[BoolArray, Float32Array, IndexArray]:
        if self.masks is not None:
            return self.masks.find(rgb)
        found = self.detector.find(rgb)
        return masks_in_boxes(self.sam, rgb, found.boxes), found.scores, found.words
