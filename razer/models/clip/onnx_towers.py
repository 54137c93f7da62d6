"""CLIP and similar models as a pair of ONNX graphs, as exported for transformers.js or from open_clip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array
from razer.errors import BadInput, one_line
from razer.models.clip.image_input import ImageInput
from razer.models.clip.onnx_pair import OnnxPair
from razer.models.clip.tokenizer import ClipTokens
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_session import open_session, providers

_NUMPY = {
    "tensor(float)": np.float32,
    "tensor(float16)": np.float16,
    "tensor(int32)": np.int32,
    "tensor(int64)": np.int64,
}
# Graphs often give the last tokens too; the vector goes by one of these names, or is the only output.
_VECTORS = ("image_embeds", "text_embeds", "image_features", "text_features", "embedding", "pooler_output")


class OnnxTowers:
    """Towers from a pair of graphs; the text tower is opened on first use. Raises BadInput."""

    patch: int | None = None

    def __init__(self, pair: OnnxPair, device: Device) -> None:
        self._pair = pair
        self._device = device
        self._image = _Graph(pair.image, device)
        self._text: tuple[_Graph, ClipTokens] | None = None
        shape = self._image.shape
        if len(shape) != 4 or self._image.type not in ("tensor(float)", "tensor(float16)"):
            raise BadInput(f"{pair.image} does not take pictures (N, 3, H, W) of floating-point numbers")
        size = shape[2] if isinstance(shape[2], int) else None
        self.image_input = ImageInput.beside(pair.image, size=size)

    def encode_images(self, batch: Float32Array) -> Float32Array:
        """See Towers."""
        return self._image(batch, 2)

    def encode_texts(self, texts: Sequence[str]) -> Float32Array:
        """See Towers."""
        if self._text is None:
            self._text = self._opened_text()
        graph, tokens = self._text
        ids, attention = tokens(texts)
        return graph(ids, 2, attention_mask=attention)

    def feature_map(self, image: Float32Array, *, aligned: bool) -> Float32Array:
        """See Towers: an output (1, D, h, w) of the image tower is a feature map aligned with text."""
        if not aligned:
            raise BadInput(f"{self._pair.image} hides its tokens: set embedder option vectors to crops or dense")
        return np.ascontiguousarray(self._image(image[None], 4)[0].transpose(1, 2, 0))

    def _opened_text(self) -> tuple[_Graph, ClipTokens]:
        if self._pair.text is None:
            raise BadInput(
                f"{self._pair.image} has no text tower beside it (text_model.onnx): ask with a picture instead"
            )
        graph = _Graph(self._pair.text, self._device)
        if len(graph.shape) != 2 or graph.type not in ("tensor(int64)", "tensor(int32)"):
            raise BadInput(f"{self._pair.text} does not take token numbers (N, length)")
        image_dimensions, text_dimensions = self._image.dimensions, graph.dimensions
        if image_dimensions and text_dimensions and not image_dimensions & text_dimensions:
            raise BadInput(
                f"{self._pair.image} and {self._pair.text} are of different models: their vectors differ in length"
            )
        length = graph.shape[1] if isinstance(graph.shape[1], int) else None
        return graph, ClipTokens(self._pair.text, length)


class _Graph:
    """A graph of one input, or of tokens and their attention mask; returns the output of a given rank."""

    def __init__(self, file: Path, device: Device) -> None:
        self._file = file
        self._session = open_session(file, providers(device))
        inputs = self._session.get_inputs()
        first = next((node for node in inputs if node.name in ("pixel_values", "input_ids")), inputs[0])
        self.name, self.shape, self.type = first.name, list(first.shape), first.type
        self._types = {node.name: node.type for node in inputs}
        surplus = self._types.keys() - {self.name, "attention_mask" if len(self.shape) == 2 else self.name}
        if surplus:
            raise BadInput(f"{file} also wants {', '.join(sorted(surplus))}: give an export with one graph per tower")

    def __call__(self, batch: NDArray, rank: int, **more: NDArray) -> Float32Array:
        """The output of that rank for all rows; a graph made for a single row gets one at a time."""
        output = self._output(rank)
        inputs = {self.name: batch, **more}
        feed = {name: inputs[name].astype(_NUMPY[kind], copy=False) for name, kind in self._types.items()}
        rows = 1 if self.shape[0] == 1 else len(batch)
        parts = [
            self._run(output, {name: values[start : start + rows] for name, values in feed.items()})
            for start in range(0, len(batch), rows)
        ]
        return np.concatenate(parts).astype(np.float32, copy=False)

    def _run(self, output: str, feed: dict[str, NDArray]) -> NDArray:
        try:
            return self._session.run([output], feed)[0]
        except Exception as error:  # ONNX Runtime's errors have no base class of their own
            shape = "x".join(map(str, feed[self.name].shape))
            raise BadInput(f"{self._file} cannot compute an input of {shape}: {one_line(error)}") from error

    @property
    def dimensions(self) -> set[int]:
        """Lengths that its vectors may have; none where the graph does not say."""
        shapes = [node.shape for node in self._session.get_outputs() if len(node.shape or ()) in (2, 4)]
        return {shape[1] for shape in shapes if isinstance(shape[1], int)}

    def _output(self, rank: int) -> str:
        of_rank = [node.name for node in self._session.get_outputs() if len(node.shape or ()) == rank]
        named = [name for name in _VECTORS if name in of_rank]
        if not of_rank:
            what = "one vector for each row" if rank == 2 else "features at each pixel (1, D, h, w)"
            fix = "" if rank == 2 else ": set embedder option vectors to crops"
            raise BadInput(f"{self._file} does not give {what}{fix}")
        return (named or of_rank)[0]
