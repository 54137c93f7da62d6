"""An ONNX file as a function of arrays: checked where it is named, loaded where it is used."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from razer.frame import BadInput

Device = Literal["auto", "cpu", "cuda"]
CUDA, CPU = "CUDAExecutionProvider", "CPUExecutionProvider"
_NUMBERS = {"tensor(float)": np.float32, "tensor(float16)": np.float16}
_ONLY_FATAL = 4  # ONNX Runtime would print what is raised anyway


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


class OnnxModel:
    """A graph of one input, of float32 or float16 numbers. device "auto" takes CUDA where ONNX Runtime has it.

    The file is read once to check it; the session that computes is opened on first use, so that the model can
    travel to another process. Raises BadInput.
    """

    def __init__(self, file: str | Path, device: Device = "auto") -> None:
        self.file = Path(file).expanduser()
        if not self.file.is_file():
            raise BadInput(f"no file {self.file}: set option weights to a model in ONNX format")
        self.device = device
        self.providers = _providers(device)
        session = self._opened(optimised=False)
        inputs = [Port.of(node) for node in session.get_inputs()]
        if len(inputs) != 1 or inputs[0].type not in _NUMBERS:
            raise BadInput(f"{self.file} does not take one image of floating-point numbers, but {_listed(inputs)}")
        self.input = inputs[0]
        self.outputs = tuple(Port.of(node) for node in session.get_outputs())
        self.metadata: dict[str, str] = dict(session.get_modelmeta().custom_metadata_map)

    def __call__(self, batch: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """All outputs for one input array, as float32; raises BadInput where the graph does not take its shape."""
        given = batch.astype(_NUMBERS[self.input.type], copy=False)
        session = self._session
        try:
            outputs = session.run(None, {self.input.name: given})
        except Exception as error:  # ONNX Runtime's errors have no base class of their own
            shape = "x".join(map(str, batch.shape))
            raise BadInput(f"{self.file} cannot compute an input of {shape}: {_first_line(error)}") from error
        return [np.asarray(output, np.float32) for output in outputs]

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_session"}

    @cached_property
    def _session(self) -> onnxruntime.InferenceSession:
        session = self._opened(optimised=True)
        if self.device == "cuda" and CUDA not in session.get_providers():
            raise BadInput("ONNX Runtime cannot start CUDA here: install CUDA's libraries, or set option device to cpu")
        return session

    def _opened(self, *, optimised: bool) -> onnxruntime.InferenceSession:
        options = onnxruntime.SessionOptions()
        options.log_severity_level = _ONLY_FATAL
        # Threads that spin while they wait take the cores from the process that maps.
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")
        if not optimised:
            options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
        try:
            return onnxruntime.InferenceSession(self.file, options, self.providers if optimised else [CPU])
        except Exception as error:  # as in __call__
            raise BadInput(f"{self.file} is no ONNX model, or is damaged: {_first_line(error)}") from error


def _providers(device: Device) -> list[str]:
    if device not in ("auto", "cpu", "cuda"):
        raise BadInput(f"option device is auto, cpu or cuda, not '{device}'")
    has_cuda = CUDA in onnxruntime.get_available_providers()
    if device == "cuda" and not has_cuda:
        raise BadInput("this ONNX Runtime has no CUDA: pip install onnxruntime-gpu, or set option device to cpu")
    return [CPU] if device == "cpu" or not has_cuda else [CUDA, CPU]


def _listed(ports: list[Port]) -> str:
    return ", ".join(f"{port} {port.type}" for port in ports) or "nothing"


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
