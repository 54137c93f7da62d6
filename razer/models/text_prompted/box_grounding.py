"""Boxes of what words name, from Grounding DINO or OWLv2."""

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

ONE_SENTENCE = {"grounding-dino", "mm-grounding-dino"}  # read all words at once, as "cup. red chair."
WORD_BY_WORD = {"owlvit", "owlv2"}
_SENTENCE_TOKENS = 256
_WORD_TOKENS = 16
_WORDS_AT_A_TIME = 64  # of models that take words apart


@dataclass(frozen=True)
class WordBoxes:
    """N boxes (N, 4) in image coordinates, left, top, right, bottom; scores (N,) in [0, 1]; words (N,), the number of
    the word that each was found for."""

    boxes: Float64Array
    scores: Float32Array
    words: IndexArray


class WordDetector:
    """A checkpoint for object detection by words. It is loaded on first use and stays behind when this travels to
    another process."""

    def __init__(self, checkpoint: Checkpoint, words: Sequence[str], confidence: float, device: Device) -> None:
        self.checkpoint, self.words, self.confidence, self.device = checkpoint, words, confidence, device
        torch_device(device)

    def find(self, rgb: Uint8Array) -> WordBoxes:
        """All boxes within an image (H, W, 3) that are sure enough, each for the word it suits best."""
        find = self._in_sentence if self.checkpoint.kind in ONE_SENTENCE else self._word_by_word
        parts = [find(rgb, numbers) for numbers in self._portions]
        height, width = rgb.shape[:2]
        boxes = np.concatenate([part.boxes for part in parts]).clip(0, [width, height, width, height])
        inside = (boxes[:, 2:] > boxes[:, :2]).all(axis=1)
        scores, words = (np.concatenate([getattr(part, name) for part in parts]) for name in ("scores", "words"))
        return WordBoxes(boxes[inside], scores[inside], words[inside])

    def __getstate__(self) -> dict[str, Any]:
        loaded = ("_model", "_processor", "_portions")
        return {name: value for name, value in self.__dict__.items() if name not in loaded}

    @cached_property
    def _model(self) -> Any:
        return self.checkpoint.load("AutoModelForZeroShotObjectDetection", self.device)

    @cached_property
    def _processor(self) -> Any:
        return self.checkpoint.part("AutoProcessor")

    @cached_property
    def _portions(self) -> list[list[int]]:
        """The numbers of the words that go into the model at a time."""
        if self.checkpoint.kind in WORD_BY_WORD:
            every = range(len(self.words))
            return [list(every[i : i + _WORDS_AT_A_TIME]) for i in range(0, len(every), _WORDS_AT_A_TIME)]
        room = self.checkpoint.config.get("max_text_len", _SENTENCE_TOKENS) - 2  # a token begins it and one ends it
        portions: list[list[int]] = [[]]
        used = 0
        for number, word in enumerate(self.words):
            length = len(self._processor.tokenizer(word, add_special_tokens=False)["input_ids"]) + 1
            if portions[-1] and used + length > room:
                portions.append([])
                used = 0
            portions[-1].append(number)
            used += length
        return portions

    def _in_sentence(self, rgb: Uint8Array, numbers: list[int]) -> WordBoxes:
        """Each token of a sentence has its score: a word's is that of its best token."""
        sentence = " ".join(f"{self.words[number].lower().replace('.', ' ')}." for number in numbers)
        inputs, outputs = self._outputs(rgb, sentence)
        tokens = self._processor.tokenizer.convert_ids_to_tokens(inputs["input_ids"][0].tolist())
        by_token = outputs.logits[0].sigmoid().float().cpu().numpy()
        by_word = np.stack([by_token[:, span].max(axis=1) for span in spans_between_stops(tokens)], axis=1)
        height, width = rgb.shape[:2]
        relative = outputs.pred_boxes[0].double().cpu().numpy().reshape(-1, 2, 2)  # centre and size, of the image's
        centre, size = (relative * (width, height)).transpose(1, 0, 2)
        boxes = np.concatenate([centre - size / 2, centre + size / 2], axis=1)
        sure = by_word.max(axis=1) > self.confidence
        return WordBoxes(boxes[sure], by_word.max(axis=1)[sure], np.array(numbers)[by_word.argmax(axis=1)[sure]])

    def _word_by_word(self, rgb: Uint8Array, numbers: list[int]) -> WordBoxes:
        length = self.checkpoint.config.get("text_config", {}).get("max_position_embeddings", _WORD_TOKENS)
        filled_up = {"padding": "max_length", "truncation": True, "max_length": length}
        _, outputs = self._outputs(rgb, [[self.words[number] for number in numbers]], **filled_up)
        found = self._processor.post_process_grounded_object_detection(
            outputs, threshold=self.confidence, target_sizes=[rgb.shape[:2]]
        )[0]
        words = np.array(numbers)[found["labels"].cpu().numpy()]
        return WordBoxes(found["boxes"].double().cpu().numpy(), found["scores"].float().cpu().numpy(), words)

    @torch.inference_mode()
    def _outputs(self, rgb: Uint8Array, text: Any, **options: Any) -> tuple[Any, Any]:
        inputs = self._processor(images=rgb, text=text, return_tensors="pt", **options).to(torch_device(self.device))
        return inputs, self._model(**inputs)


def spans_between_stops(tokens: Sequence[str]) -> Iterator[slice]:
    """The tokens of each word of a sentence like "cup. red chair.", without the stops and the first, which begins
    the sentence."""
    start = 1
    for place, token in enumerate(tokens):
        if token == ".":
            yield slice(start, place)
            start = place + 1
