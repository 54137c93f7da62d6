"""Opening a model of SAM's family, whichever library runs it."""

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
    """A promptable model of the ONNX or the `transformers` library.

    Args:
        weights: a folder with both ONNX files of an export or with a checkpoint, the encoder's file, or a name of the
            catalogue.
        decoder: the decoder's file where `weights` is the encoder's.
        batch: prompts at a time.
        device: auto, cpu or cuda.

    Raises:
        BadInput: where there is no such model.
    """
    path = model_file(weights)
    if decoder is not None:
        return OnnxSam(path, model_file(decoder), batch, device)
    if any(path.glob("*.safetensors")):
        return TorchSam(Checkpoint.of(path), batch, device)
    entry = catalogue().get(str(weights))
    # The hub's cache may hold more of a repository than the catalogue names.
    return OnnxSam(*encoder_and_decoder(path, entry.files if entry else ()), batch, device)
