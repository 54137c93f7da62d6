"""ONNX Runtime sessions, set up to leave cores to the rest of the method and to report errors in one line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import onnxruntime

from razer.errors import BadInput, one_line
from razer.models.runtime.device import Device

CUDA, CPU = "CUDAExecutionProvider", "CPUExecutionProvider"
_ONLY_FATAL = 4  # ONNX Runtime would print what is raised anyway


def providers(device: Device) -> list[str]:
    """Execution providers, the preferred first; raises BadInput."""
    if device not in ("auto", "cpu", "cuda"):
        raise BadInput(f"option device is auto, cpu or cuda, not '{device}'")
    has_cuda = CUDA in onnxruntime.get_available_providers()
    if device == "cuda" and not has_cuda:
        raise BadInput("this ONNX Runtime has no CUDA: pip install onnxruntime-gpu, or set option device to cpu")
    return [CPU] if device == "cpu" or not has_cuda else [CUDA, CPU]


def open_session(file: Path, providers: Sequence[str], *, optimised: bool = True) -> onnxruntime.InferenceSession:
    """A session of a graph; one that is only inspected need not be optimised. Raises BadInput."""
    onnxruntime.set_default_logger_severity(_ONLY_FATAL)  # of graphs while they are read, which sessions do not cover
    options = onnxruntime.SessionOptions()
    options.log_severity_level = _ONLY_FATAL
    # Threads that spin while they wait take the cores from the process that maps.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    if not optimised:
        options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    try:
        return onnxruntime.InferenceSession(file, options, list(providers))
    except Exception as error:  # ONNX Runtime's errors have no base class of their own
        raise BadInput(f"{file} is no ONNX model, or is damaged: {_reason(error)}") from error


def _reason(error: Exception) -> str:
    """What the runtime says, without its own name and number of the error."""
    return re.sub(r"^\[ONNXRuntimeError\] : \d+ : \w+ : ", "", one_line(error))
