"""Closed-set instance segmentation by an RF-DETR model in ONNX format (Robinson et al. 2025)."""

from __future__ import annotations

from pathlib import Path

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.rfdetr.decoder import decode_queries
from razer.models.rfdetr.export import RfDetrExport
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_model import OnnxModel
from razer.models.square_layout import SquareLayout


class RfDetrSegmenter:
    """RF-DETR-Seg as its package exports it to ONNX, trained on COCO or on classes of one's own.

    The signature is that of https://huggingface.co/besit/rfdetr-onnx and of `export` in
    https://github.com/roboflow/rf-detr (see RfDetrExport).

    Args:
        weights: the ONNX file.
        names: a file with the class names, for models trained on classes of one's own; None = those of the metadata,
            else COCO's.
        confidence: lowest score of a mask; 0.5 is what its own `predict` takes. Lower: more small objects, and more
            false ones.
        max_masks: at most so many, the best.
        device: auto, cpu or cuda.

    Raises:
        BadInput: for impossible options, and a file that is no RF-DETR segmentation model.
    """

    looks_at_color_alone = True

    def __init__(
        self,
        weights: str | Path,
        names: str | None = None,
        confidence: float = 0.5,
        max_masks: int = 100,
        device: Device = "auto",
    ) -> None:
        if not (0 < confidence <= 1 and max_masks >= 1):
            raise BadInput("the rfdetr segmenter takes confidence above 0 and up to 1, and max_masks >= 1")
        self.model = OnnxModel(weights, device)
        self.export = RfDetrExport.of(self.model, names)
        self.confidence, self.max_masks = confidence, max_masks

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, best first; they may overlap. Raises BadInput for outputs unlike RF-DETR's."""
        image = frame.intrinsics.height, frame.intrinsics.width
        outputs = self.model(SquareLayout.of(*image, self.export.side, stretched=True).square(frame.rgb))
        logits, masks = outputs[self.export.logits][0], outputs[self.export.masks][0]
        names = self.export.class_names
        if logits.shape != (len(masks), len(names)):
            raise BadInput(f"{self.model.file} gives {logits.shape} scores for {len(masks)} masks, {len(names)} names")
        return decode_queries(logits, masks, names, image, self.confidence, self.max_masks)
