"""Where torch computes."""

from __future__ import annotations

import torch

from razer.frame import BadInput


def torch_device(choice: str) -> torch.device:
    """ "cpu", "cuda", or "auto": CUDA where there is one. Raises BadInput."""
    if choice not in ("auto", "cpu", "cuda"):
        raise BadInput(f"embedder option device is auto, cpu or cuda, not '{choice}'")
    if choice == "cuda" and not torch.cuda.is_available():
        raise BadInput("torch finds no CUDA device here: set embedder option device to cpu or auto")
    return torch.device("cuda" if choice != "cpu" and torch.cuda.is_available() else "cpu")
