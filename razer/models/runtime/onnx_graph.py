"""ONNX graphs as functions of named arrays, checked at construction and loaded on first use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from razer.errors import BadInput, one_line
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_session import CPU, CUDA, open_session, providers

_TYPES = {
    "tensor(float)": np.float32, "tensor(float16)": np.float16, "tensor(uint8)": np.uint8,
    "tensor(int32)": np.int32, "tensor(int64)": np.int64,
}  # fmt: skip


@dataclass(frozen=True)
class TensorSpec:
    """An input or output of a graph; a dynamic dimension is None."""

    name: str
    shape: tuple[int | None, ...]
    type: str

    @classmethod
    def of(cls, node: Any) -> TensorSpec:
        """From ONNX Runtime's description, where a dynamic dimension is a name or None."""
        return cls(node.name, tuple(side if isinstance(side, int) else None for side in node.shape), node.type)

    def __str__(self) -> str:
        return f"{self.name} {'x'.join('?' if side is None else str(side) for side in self.shape)}"


class OnnxGraph:
    """A graph with its `inputs` and `outputs` by name, and the `metadata` in its file. device "auto" takes CUDA where
    ONNX Runtime has it.

    The file is read once to check it; the session that computes is opened on first use, so that the graph can be
    sent to another process. Raises BadInput.
    """

    def __init__(self, file: Path, device: Device = "auto") -> None:
        self.file, self.device, self.providers = file, device, providers(device)
        session = open_session(file, [CPU], optimised=False)
        self.inputs = {node.name: TensorSpec.of(node) for node in session.get_inputs()}
        self.outputs = {node.name: TensorSpec.of(node) for node in session.get_outputs()}
        self.metadata: dict[str, str] = dict(session.get_modelmeta().custom_metadata_map)
        for spec in self.inputs.values():
            if spec.type not in _TYPES:
                raise BadInput(f"{file} takes {spec} as {spec.type}, which no known model does")

    def __call__(self, feeds: Mapping[str, NDArray]) -> dict[str, NDArray]:
        """All outputs by name for inputs by name; arrays are cast to the types of the graph, and float16 outputs to
        float32. Raises BadInput where the graph does not take the shapes."""
        inputs = {name: np.ascontiguousarray(array, _TYPES[self.inputs[name].type]) for name, array in feeds.items()}
        session = self._session
        try:
            outputs = session.run(None, inputs)
        except Exception as error:  # ONNX Runtime's errors have no base class of their own
            shapes = ", ".join(f"{name} {'x'.join(map(str, array.shape))}" for name, array in feeds.items())
            raise BadInput(f"{self.file} cannot compute {shapes}: {one_line(error)}") from error
        arrays = (np.asarray(output) for output in outputs)
        return {
            name: array.astype(np.float32) if array.dtype == np.float16 else array
            for name, array in zip(self.outputs, arrays, strict=True)
        }

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_session"}

    @cached_property
    def _session(self) -> onnxruntime.InferenceSession:
        session = open_session(self.file, self.providers)
        if self.device == "cuda" and CUDA not in session.get_providers():
            raise BadInput("ONNX Runtime cannot start CUDA here: install CUDA's libraries, or set option device to cpu")
        return session
