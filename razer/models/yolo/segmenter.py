"""Closed-set instance segmentation by a YOLO model in ONNX format."""

from __future__ import annotations

from pathlib import Path

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_model import OnnxModel
from razer.models.yolo.decoder import YoloDecoder
from razer.models.yolo.export import YoloExport


class YoloSegmenter:
    """Any segmentation model that Ultralytics exports: YOLOv8, 11 and 26, YOLOE, FastSAM.

    Args:
        weights: the ONNX file; class names come from its metadata.
        confidence: lowest score of a mask. Lower: more small objects, and more false ones.
        iou: overlap of boxes of one class above which the lower score is suppressed. Lower: objects that stand close
            become one; higher: one object has several masks.
        max_masks: at most so many, the best.
        size: longest side of the input in pixels, where the model leaves it open. Smaller: faster, small objects are
            lost.
        device: auto, cpu or cuda.

    Raises:
        BadInput: for impossible options, and a file that is no YOLO segmentation model.
    """

    looks_at_color_alone = True

    def __init__(
        self,
        weights: str | Path,
        confidence: float = 0.25,
        iou: float = 0.7,
        max_masks: int = 100,
        size: int | None = None,
        device: Device = "auto",
    ) -> None:
        if not (0 < confidence <= 1 and 0 < iou <= 1 and max_masks >= 1):
            raise BadInput("the yolo segmenter takes confidence and iou above 0 and up to 1, and max_masks >= 1")
        self.model = OnnxModel(weights, device)
        self.export = YoloExport.of(self.model, size)
        self.decoder = YoloDecoder(str(weights), self.export.class_names, confidence, iou, max_masks)
        self._check_layout()

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, best first; they may overlap. Raises BadInput for outputs unlike YOLO's."""
        letterbox = self.export.letterbox((frame.intrinsics.height, frame.intrinsics.width))
        outputs = self.model(letterbox.batch(frame.rgb))
        return self.decoder.masks(outputs[self.export.predictions], outputs[self.export.prototypes], letterbox)

    def _check_layout(self) -> None:
        """Refuse a file with outputs of fixed shape unlike YOLO's; open ones are checked at the first frame."""
        rows, columns = self.model.outputs[self.export.predictions].shape[1:]
        n_prototypes = self.model.outputs[self.export.prototypes].shape[1]
        if rows is not None and columns is not None and n_prototypes is not None:
            self.decoder.layout(rows, columns, n_prototypes)
