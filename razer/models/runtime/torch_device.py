"""Torch device of a setting."""

from __future__ import annotations

import torch

from razer.errors import BadInput
from razer.models.runtime.device import Device


def torch_device(device: Device) -> torch.device:
    """The torch device of a setting; raises BadInput."""
    if device not in ("auto", "cpu", "cuda"):
        raise BadInput(f"option device is auto, cpu or cuda, not '{device}'")
    if device == "cuda" and not torch.cuda.is_available():
        raise BadInput("torch finds no CUDA device here: set option device to cpu or auto")
    return torch.device("cuda" if device != "cpu" and torch.cuda.is_available() else "cpu")
