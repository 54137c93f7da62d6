"""SAM's image encoder: an image becomes features, once for all prompts."""

from __future__ import annotations

from numpy.typing import NDArray

from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.models.runtime.onnx_graph import OnnxGraph
from razer.models.square_layout import SquareLayout

_USUAL_SIDE = 1024
_LEVELS_OF_SAM2 = 3


class SamEncoder:
    """An encoder graph of any of the known exports.

    It takes one image, either (1, 3, S, S) normalised, or (H, W, 3) with colours up to 255 and its longer side S,
    which it normalises itself. A graph with three feature maps is of the family of SAM 2. Raises BadInput.
    """

    def __init__(self, graph: OnnxGraph) -> None:
        self.graph = graph
        specs = list(graph.inputs.values())
        shape = specs[0].shape if len(specs) == 1 else ()
        self.raw = len(shape) == 3 and shape[2] in (3, None)
        if not self.raw and not (len(shape) == 4 and shape[1] in (3, None)):
            listed = ", ".join(map(str, specs))
            raise BadInput(f"{graph.file} is no SAM encoder: it takes {listed}, not one image of 3 colours")
        self.input = specs[0].name
        self.side = (None if self.raw else shape[2]) or _USUAL_SIDE
        self.stretched = len(graph.outputs) >= _LEVELS_OF_SAM2

    def encode(self, rgb: Uint8Array) -> tuple[dict[str, NDArray], SquareLayout]:
        """The features of an image (H, W, 3) by name, and its layout in the square."""
        height, width = rgb.shape[:2]
        layout = SquareLayout.of(height, width, self.side, self.stretched)
        return self.graph({self.input: layout.resized(rgb) if self.raw else layout.square(rgb)}), layout
