"""Panoptic segmentation by Mask2Former, OneFormer and similar models: things and stuff, every pixel in one mask."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import torch

from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.panoptic_masks import panoptic_masks
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device
from razer.models.stuff_names import stuff_classes

_KINDS = {"mask2former", "oneformer", "maskformer"}
_TASK = "the task is panoptic"  # OneFormer's task prompt, as in its training
_TASK_TOKENS = 77


class PanopticSegmenter:
    """A checkpoint of the `transformers` library for universal segmentation.

    weights: its folder, or a name of the catalogue or the hub. confidence: lowest score of a mask. Lower: more of the
    image is covered, with more errors. device: auto, cpu or cuda. Raises BadInput.
    """

    looks_at_color_alone = True

    def __init__(self, weights: str | Path, confidence: float = 0.5, device: Device = "auto") -> None:
        if not 0 <= confidence <= 1:
            raise BadInput(f"segmenter option confidence is from 0 to 1, not {confidence}")
        self.checkpoint, self.confidence, self.device = Checkpoint.of(weights), confidence, device
        if self.checkpoint.kind not in _KINDS:
            supported = ", ".join(sorted(_KINDS))
            raise BadInput(f"{self.checkpoint.folder} holds '{self.checkpoint.kind}', and panoptic takes {supported}")
        torch_device(device)

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame with the names of their classes, stuff flagged by these; they do not overlap."""
        outputs = self._outputs(frame.rgb)
        size = (frame.intrinsics.height, frame.intrinsics.width)
        masks, scores, classes = panoptic_masks(
            outputs.class_queries_logits[0].float(), outputs.masks_queries_logits[0].float(), size, self.confidence
        )
        names = self._model.config.id2label
        class_names = tuple(names[number] for number in classes.tolist())
        return Masks(masks.cpu().numpy(), scores.cpu().numpy(), class_names, stuff_classes(class_names))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_model", "_processor", "_task")}

    @torch.inference_mode()
    def _outputs(self, rgb: Uint8Array) -> Any:
        device = torch_device(self.device)
        inputs = {**self._processor(rgb, return_tensors="pt"), **self._task}
        return self._model(**{name: tensor.to(device) for name, tensor in inputs.items()})

    @property
    def _is_oneformer(self) -> bool:
        return self.checkpoint.kind == "oneformer"

    @cached_property
    def _model(self) -> Any:
        return self.checkpoint.load("AutoModelForUniversalSegmentation", self.device)

    @cached_property
    def _processor(self) -> Any:
        # OneFormer's would fetch a list of classes from the hub, which only training needs.
        options = {"class_info_file": None} if self._is_oneformer else {}
        return self.checkpoint.part("AutoImageProcessor", **options)

    @cached_property
    def _task(self) -> dict[str, torch.Tensor]:
        if not self._is_oneformer:
            return {}
        length = self.checkpoint.config.get("task_seq_len", _TASK_TOKENS)
        tokens = self.checkpoint.part("AutoTokenizer")(
            _TASK, padding="max_length", max_length=length, truncation=True, return_tensors="pt"
        )
        return {"task_inputs": tokens["input_ids"] * tokens["attention_mask"]}
