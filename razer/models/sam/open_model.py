"""From what the options say to a model of SAM's family, whichever library runs it."""

from __future__ import annotations

from pathlib import Path

from razer.models.hub.catalogue import catalogue
from razer.models.hub.model_file import model_file
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.sam.export_files import encoder_and_decoder
from razer.models.sam.onnx_sam import OnnxSam
from razer.models.sam.promptable import Promptable
from razer.models.sam.torch_sam import TorchSam


def sam_model(weights: str | Path, decoder: str | Path | None, batch: int, device: Device) -> Promptable:
    """An export in two ONNX files, given as their folder or one by one, or a checkpoint of the `transformers` library;
    `batch` prompts are answered at a time. Raises BadInput."""
    where = model_file(weights)
    if decoder is not None:
        return OnnxSam(where, model_file(decoder), batch, device)
    if any(where.glob("*.safetensors")):
        return TorchSam(Checkpoint.of(where), batch, device)
    listed = catalogue().get(str(weights))
    # The hub's cache may hold more of a repository than the catalogue names.
    return OnnxSam(*encoder_and_decoder(where, listed.files if listed else ()), batch, device)
