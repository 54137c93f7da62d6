"""SAM checkpoints of the `transformers` library, run by torch."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import torch

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.errors import BadInput
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device
from razer.models.sam.promptable import MaskBatches
from razer.models.square_layout import SquareLayout

_KEEPS_SHAPE = {"sam"}
_STRETCHES = {"sam2", "sam2_video", "sam3_tracker", "edgetam", "edgetam_video"}


class TorchSam:
    """SAM, SAM 2 and similar models; a Promptable. The model is loaded on first use and is not pickled. Raises BadInput
    for other checkpoints."""

    def __init__(self, checkpoint: Checkpoint, batch: int, device: Device) -> None:
        if checkpoint.kind not in _KEEPS_SHAPE | _STRETCHES:
            raise BadInput(f"{checkpoint.folder} holds '{checkpoint.kind}', which is no model of SAM's family")
        self.checkpoint, self.batch, self.device = checkpoint, batch, device
        self.colours = checkpoint.colours()
        torch_device(device)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_model"}

    @cached_property
    def _model(self) -> Any:
        return self.checkpoint.load("AutoModelForMaskGeneration", self.device)

    @torch.inference_mode()
    def encode(self, rgb: Uint8Array) -> tuple[Any, SquareLayout]:
        """As Promptable."""
        height, width = rgb.shape[:2]
        side = self._model.prompt_encoder.input_image_size
        layout = SquareLayout.of(height, width, side, self.checkpoint.kind in _STRETCHES)
        square = torch.from_numpy(layout.square(rgb, *self.colours)).to(torch_device(self.device))
        return self._model.get_image_embeddings(square), layout

    def at_points(self, features: Any, layout: SquareLayout, points: Float64Array) -> MaskBatches:
        """As Promptable."""
        yield from self._answers(features, layout, "input_points", layout.coordinates(points)[:, None])

    def in_boxes(self, features: Any, layout: SquareLayout, boxes: Float64Array) -> MaskBatches:
        """As Promptable."""
        corners = layout.coordinates(boxes.reshape(-1, 2, 2)).reshape(-1, 4)
        yield from self._answers(features, layout, "input_boxes", corners)

    def _answers(self, features: Any, layout: SquareLayout, name: str, prompts: Float32Array) -> MaskBatches:
        device = torch_device(self.device)
        for start in range(0, len(prompts), self.batch):
            part = torch.from_numpy(prompts[None, start : start + self.batch]).to(device)
            with torch.inference_mode():
                outputs = self._model(image_embeddings=features, **{name: part})
            masks, scores = outputs.pred_masks[0].float(), outputs.iou_scores[0].float()
            yield layout.filled(masks.cpu().numpy()), scores.cpu().numpy()
