"""ONNX graphs with a single input array."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.models.hub.model_file import model_file
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_graph import OnnxGraph

_FLOATING = ("tensor(float)", "tensor(float16)")


class OnnxModel:
    """A graph of one input, of float32 or float16 numbers; weights is what `model_file` takes. Raises BadInput."""

    def __init__(self, weights: str | Path, device: Device = "auto") -> None:
        file = model_file(weights)
        if not file.is_file():
            raise BadInput(f"{file} is a folder: set option weights to a model in ONNX format")
        self._graph = OnnxGraph(file, device)
        self.file, self.metadata, self.providers = self._graph.file, self._graph.metadata, self._graph.providers
        inputs = list(self._graph.inputs.values())
        if len(inputs) != 1 or inputs[0].type not in _FLOATING:
            taken = ", ".join(f"{spec} {spec.type}" for spec in inputs) or "nothing"
            raise BadInput(f"{self.file} does not take one image of floating-point numbers, but {taken}")
        self.input = inputs[0]
        self.outputs = tuple(self._graph.outputs.values())

    def __call__(self, batch: Float32Array) -> list[Float32Array]:
        """All outputs for one input array, as float32; raises BadInput where the graph does not take its shape."""
        outputs = self._graph({self.input.name: batch})
        return [np.asarray(output, np.float32) for output in outputs.values()]
