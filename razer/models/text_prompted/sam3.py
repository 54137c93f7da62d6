"""Open-vocabulary segmentation by SAM 3, detector and masks in one model."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import torch

from razer.arrays import BoolArray, Float32Array, IndexArray, Uint8Array
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device
from razer.models.sam.mask_proposals import masks_at_size
from razer.models.square_layout import SquareLayout

SAM3_KINDS = {"sam3", "sam3_video"}
_TEXT_TOKENS = 32  # to which SAM 3 fills up a text


class Sam3Detector:
    """A SAM 3 checkpoint. It is loaded on first use and is not pickled.

    Args:
        checkpoint: of SAM 3.
        phrases: names of what is to be segmented.
        confidence: lowest score of a mask, in [0, 1].
        device: auto, cpu or cuda.
    """

    def __init__(self, checkpoint: Checkpoint, phrases: Sequence[str], confidence: float, device: Device) -> None:
        self.checkpoint, self.phrases, self.confidence, self.device = checkpoint, phrases, confidence, device
        self.colours = checkpoint.colours()
        torch_device(device)

    def detect(self, rgb: Uint8Array) -> tuple[BoolArray, Float32Array, IndexArray]:
        """Masks (N, H, W) of an image (H, W, 3), scores (N,) in [0, 1] and the index of each one's phrase (N,)."""
        height, width = rgb.shape[:2]
        masks, scores, phrases = [np.zeros((0, height, width), bool)], [np.zeros(0, np.float32)], [np.zeros(0, np.intp)]
        vision = self._vision_features(rgb)
        for index, text in enumerate(self._texts):
            logits, score = self._candidates(vision, text)
            is_confident = score > self.confidence
            masks.append(masks_at_size(logits[is_confident], height, width))
            scores.append(score[is_confident])
            phrases.append(np.full(is_confident.sum(), index))
        return np.concatenate(masks), np.concatenate(scores), np.concatenate(phrases)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_model", "_texts")}

    @cached_property
    def _model(self) -> Any:
        return self.checkpoint.load("Sam3Model", self.device)

    @cached_property
    def _texts(self) -> list[Any]:
        tokenizer = self.checkpoint.part("AutoTokenizer")
        return [
            tokenizer(phrase, padding="max_length", max_length=_TEXT_TOKENS, truncation=True, return_tensors="pt")
            for phrase in self.phrases
        ]

    @torch.inference_mode()
    def _vision_features(self, rgb: Uint8Array) -> Any:
        height, width = rgb.shape[:2]
        side = self._model.config.vision_config.backbone_config.image_size
        square = SquareLayout.of(height, width, side, stretched=True).square(rgb, *self.colours)
        return self._model.get_vision_features(torch.from_numpy(square).to(torch_device(self.device)))

    @torch.inference_mode()
    def _candidates(self, vision: Any, text: Any) -> tuple[Float32Array, Float32Array]:
        """Logits (Q, h, w) and scores (Q,) of all candidates for one phrase."""
        text = text.to(torch_device(self.device))
        outputs = self._model(vision_embeds=vision, input_ids=text["input_ids"], attention_mask=text["attention_mask"])
        scores = outputs.pred_logits[0].sigmoid()
        if outputs.presence_logits is not None:
            scores = scores * outputs.presence_logits[0].sigmoid()
        return outputs.pred_masks[0].float().cpu().numpy(), scores.float().cpu().numpy()
