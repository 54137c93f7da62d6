"""An ONNX file as a function of named arrays: checked where it is named, loaded where it is used."""

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
class Port:
    """An input or output of a graph; a side that may vary is None."""

    name: str
    shape: tuple[int | None, ...]
    type: str

    @classmethod
    def of(cls, node: Any) -> Port:
        """What ONNX Runtime tells of an input or output, where a side that varies is a name or nothing."""
        return cls(node.name, tuple(side if isinstance(side, int) else None for side in node.shape), node.type)

    def __str__(self) -> str:
        return f"{self.name} {'x'.join('?' if side is None else str(side) for side in self.shape)}"


class OnnxGraph:
    """A graph with its `inputs` and `outputs` by name, and the `metadata` in its file. device "auto" takes CUDA where
    ONNX Runtime has it.

    The file is read once to check it; the session that computes is opened on first use, so that the graph can travel
    to another process. Raises BadInput.
    """

    def __init__(self, file: Path, device: Device = "auto") -> None:
        self.file, self.device, self.providers = file, device, providers(device)
        session = open_session(file, [CPU], optimised=False)
        self.inputs = {node.name: Port.of(node) for node in session.get_inputs()}
        self.outputs = {node.name: Port.of(node) for node in session.get_outputs()}
        self.metadata: dict[str, str] = dict(session.get_modelmeta().custom_metadata_map)
        for port in self.inputs.values():
            if port.type not in _TYPES:
                raise BadInput(f"{file} takes {port} as {port.type}, which no known model does")

    def __call__(self, feeds: Mapping[str, NDArray]) -> dict[str, NDArray]:
        """All outputs by name for inputs by name; numbers are brought to the types the graph wants, and float16 back
        to float32. Raises BadInput where the graph does not take the shapes."""
        given = {name: np.ascontiguousarray(array, _TYPES[self.inputs[name].type]) for name, array in feeds.items()}
        session = self._session
        try:
            outputs = session.run(None, given)
        except Exception as error:  # ONNX Runtime's errors have no base class of their own
            shapes = ", ".join(f"{name} {'x'.join(map(str, array.shape))}" for name, array in feeds.items())
            raise BadInput(f"{self.file} cannot compute {shapes}: {one_line(error)}") from error
        half = (np.asarray(output) for output in outputs)
        return {
            name: array.astype(np.float32) if array.dtype == np.float16 else array
            for name, array in zip(self.outputs, half, strict=True)
        }

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_session"}

    @cached_property
    def _session(self) -> onnxruntime.InferenceSession:
        session = open_session(self.file, self.providers)
        if self.device == "cuda" and CUDA not in session.get_providers():
            raise BadInput("ONNX Runtime cannot start CUDA here: install CUDA's libraries, or set option device to cpu")
        return session
