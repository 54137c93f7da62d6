"""A SAM export in ONNX format: encoder and decoder graphs as one promptable model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from numpy.typing import NDArray

from razer.arrays import Float64Array, Uint8Array
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_graph import OnnxGraph
from razer.models.sam.decoder import SamDecoder
from razer.models.sam.encoder import SamEncoder
from razer.models.sam.promptable import MaskBatches
from razer.models.square_layout import SquareLayout


class OnnxSam:
    """Encoder and decoder of one export; a Promptable.

    Args:
        encoder: its ONNX file.
        decoder: its ONNX file.
        batch: prompts at a time, where the decoder leaves that open.
        device: auto, cpu or cuda.

    Raises:
        BadInput: where the two files are not of one export.
    """

    def __init__(self, encoder: Path, decoder: Path, batch: int, device: Device) -> None:
        self.encoder = SamEncoder(OnnxGraph(encoder, device))
        self.decoder = SamDecoder(OnnxGraph(decoder, device), self.encoder.graph.outputs, batch)

    def encode(self, rgb: Uint8Array) -> tuple[dict[str, NDArray], SquareLayout]:
        """As Promptable."""
        return self.encoder.encode(rgb)

    def at_points(self, features: Mapping[str, NDArray], layout: SquareLayout, points: Float64Array) -> MaskBatches:
        """As Promptable."""
        return self.decoder.at_points(features, layout, points)

    def in_boxes(self, features: Mapping[str, NDArray], layout: SquareLayout, boxes: Float64Array) -> MaskBatches:
        """As Promptable."""
        return self.decoder.in_boxes(features, layout, boxes)
