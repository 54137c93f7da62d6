"""Open-vocabulary object detection by Grounding DINO or OWLv2."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import torch

from razer.arrays import Float32Array, Float64Array, IndexArray, Uint8Array
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device

SENTENCE_KINDS = {"grounding-dino", "mm-grounding-dino"}  # take all phrases in one text, as "cup. red chair."
PHRASE_KINDS = {"owlvit", "owlv2"}
_SENTENCE_TOKENS = 256
_PHRASE_TOKENS = 16
_PHRASES_PER_BATCH = 64  # of models that encode each phrase by itself


@dataclass(frozen=True)
class PhraseBoxes:
    """N boxes (N, 4) in image coordinates, left, top, right, bottom; scores (N,) in [0, 1]; phrases (N,), the
    index of the phrase that each was detected by."""

    boxes: Float64Array
    scores: Float32Array
    phrases: IndexArray


class PhraseDetector:
    """A checkpoint for zero-shot object detection. It is loaded on first use and is not pickled.

    Args:
        checkpoint: of Grounding DINO or OWLv2.
        phrases: names of what is to be detected.
        confidence: lowest score of a box, in [0, 1].
        device: auto, cpu or cuda.
    """

    def __init__(self, checkpoint: Checkpoint, phrases: Sequence[str], confidence: float, device: Device) -> None:
        self.checkpoint, self.phrases, self.confidence, self.device = checkpoint, phrases, confidence, device
        torch_device(device)

    def detect(self, rgb: Uint8Array) -> PhraseBoxes:
        """All boxes within an image (H, W, 3) above the confidence, each for the phrase it scores best for."""
        detect = self._by_sentence if self.checkpoint.kind in SENTENCE_KINDS else self._by_phrase
        parts = [detect(rgb, indices) for indices in self._batches]
        height, width = rgb.shape[:2]
        boxes = np.concatenate([part.boxes for part in parts]).clip(0, [width, height, width, height])
        inside = (boxes[:, 2:] > boxes[:, :2]).all(axis=1)
        scores, phrases = (np.concatenate([getattr(part, name) for part in parts]) for name in ("scores", "phrases"))
        return PhraseBoxes(boxes[inside], scores[inside], phrases[inside])

    def __getstate__(self) -> dict[str, Any]:
        loaded = ("_model", "_processor", "_batches")
        return {name: value for name, value in self.__dict__.items() if name not in loaded}

    @cached_property
    def _model(self) -> Any:
        return self.checkpoint.load("AutoModelForZeroShotObjectDetection", self.device)

    @cached_property
    def _processor(self) -> Any:
        return self.checkpoint.part("AutoProcessor")

    @cached_property
    def _batches(self) -> list[list[int]]:
        """The indices of the phrases that go into the model at a time."""
        if self.checkpoint.kind in PHRASE_KINDS:
            indices = range(len(self.phrases))
            return [list(indices[i : i + _PHRASES_PER_BATCH]) for i in range(0, len(indices), _PHRASES_PER_BATCH)]
        room = self.checkpoint.config.get("max_text_len", _SENTENCE_TOKENS) - 2  # a token begins it and one ends it
        batches: list[list[int]] = [[]]
        used = 0
        for index, phrase in enumerate(self.phrases):
            length = len(self._processor.tokenizer(phrase, add_special_tokens=False)["input_ids"]) + 1
            if batches[-1] and used + length > room:
                batches.append([])
                used = 0
            batches[-1].append(index)
            used += length
        return batches

    def _by_sentence(self, rgb: Uint8Array, indices: list[int]) -> PhraseBoxes:
        """Each token of a sentence has its score: a phrase's is that of its best token."""
        sentence = " ".join(f"{self.phrases[index].lower().replace('.', ' ')}." for index in indices)
        inputs, outputs = self._outputs(rgb, sentence)
        tokens = self._processor.tokenizer.convert_ids_to_tokens(inputs["input_ids"][0].tolist())
        by_token = outputs.logits[0].sigmoid().float().cpu().numpy()
        by_phrase = np.stack([by_token[:, span].max(axis=1) for span in phrase_spans(tokens)], axis=1)
        height, width = rgb.shape[:2]
        relative = outputs.pred_boxes[0].double().cpu().numpy().reshape(-1, 2, 2)  # centre and size, of the image's
        centre, size = (relative * (width, height)).transpose(1, 0, 2)
        boxes = np.concatenate([centre - size / 2, centre + size / 2], axis=1)
        scores, phrases = by_phrase.max(axis=1), np.array(indices)[by_phrase.argmax(axis=1)]
        is_confident = scores > self.confidence
        return PhraseBoxes(boxes[is_confident], scores[is_confident], phrases[is_confident])

    def _by_phrase(self, rgb: Uint8Array, indices: list[int]) -> PhraseBoxes:
        length = self.checkpoint.config.get("text_config", {}).get("max_position_embeddings", _PHRASE_TOKENS)
        padding = {"padding": "max_length", "truncation": True, "max_length": length}
        _, outputs = self._outputs(rgb, [[self.phrases[index] for index in indices]], **padding)
        detections = self._processor.post_process_grounded_object_detection(
            outputs, threshold=self.confidence, target_sizes=[rgb.shape[:2]]
        )[0]
        phrases = np.array(indices)[detections["labels"].cpu().numpy()]
        boxes, scores = detections["boxes"].double().cpu().numpy(), detections["scores"].float().cpu().numpy()
        return PhraseBoxes(boxes, scores, phrases)

    @torch.inference_mode()
    def _outputs(self, rgb: Uint8Array, text: Any, **options: Any) -> tuple[Any, Any]:
        inputs = self._processor(images=rgb, text=text, return_tensors="pt", **options).to(torch_device(self.device))
        return inputs, self._model(**inputs)


def phrase_spans(tokens: Sequence[str]) -> Iterator[slice]:
    """The tokens of each phrase of a sentence like "cup. red chair.", without the stops and the first, which begins
    the sentence."""
    start = 1
    for position, token in enumerate(tokens):
        if token == ".":
            yield slice(start, position)
            start = position + 1
