"""Encoder and decoder files of a SAM export in ONNX format."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from razer.errors import BadInput

_OR_BOTH_FILES = "or to segmenter sam the encoder with option decoder"


def encoder_and_decoder(folder: Path, known: Sequence[str] = ()) -> tuple[Path, Path]:
    """The encoder and the decoder among the ONNX files of a folder or its subfolder `onnx`, or among those `known`
    there, by their names; a "prompt_encoder_mask_decoder" is a decoder. Raises BadInput unless there is one of each."""
    if not folder.is_dir():
        raise BadInput(f"{folder} is one file, and SAM exports are two: give the folder of both, {_OR_BOTH_FILES}")
    files = [folder / name for name in known] or sorted([*folder.glob("*.onnx"), *folder.glob("onnx/*.onnx")])
    decoders = [file for file in files if "decoder" in file.stem.lower()]
    encoders = [file for file in files if "encoder" in file.stem.lower() and file not in decoders]
    if len(encoders) == 1 and len(decoders) == 1:
        return encoders[0], decoders[0]
    names = ", ".join(file.name for file in files) or "no ONNX file"
    raise BadInput(
        f"{folder} should hold one *encoder*.onnx and one *decoder*.onnx, and holds {names}: "
        f"give a folder with just the two, {_OR_BOTH_FILES}"
    )
