"""The image side of SAM: a picture becomes features, once for all prompts."""

from __future__ import annotations

from numpy.typing import NDArray

from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.models.model_view import ModelView
from razer.models.runtime.onnx_graph import OnnxGraph

_USUAL_SIDE = 1024
_LEVELS_OF_SAM2 = 3


class SamEncoder:
    """An encoder graph of any of the known exports.

    It takes one image, either (1, 3, S, S) normalised, or (H, W, 3) with colours up to 255 and its longer side S,
    which it normalises itself. What gives three maps of features is of the family of SAM 2. Raises BadInput.
    """

    def __init__(self, graph: OnnxGraph) -> None:
        self.graph = graph
        ports = list(graph.inputs.values())
        shape = ports[0].shape if len(ports) == 1 else ()
        self.raw = len(shape) == 3 and shape[2] in (3, None)
        if not self.raw and not (len(shape) == 4 and shape[1] in (3, None)):
            listed = ", ".join(map(str, ports))
            raise BadInput(f"{graph.file} is no SAM encoder: it takes {listed}, not one image of 3 colours")
        self.input = ports[0].name
        self.side = (None if self.raw else shape[2]) or _USUAL_SIDE
        self.stretched = len(graph.outputs) >= _LEVELS_OF_SAM2

    def encode(self, rgb: Uint8Array) -> tuple[dict[str, NDArray], ModelView]:
        """The features of an image (H, W, 3) by name, and how it lies in the square."""
        height, width = rgb.shape[:2]
        view = ModelView.of(height, width, self.side, self.stretched)
        return self.graph({self.input: view.resized(rgb) if self.raw else view.square(rgb)}), view
