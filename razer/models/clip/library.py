"""Choice of the library that runs an image-text model, by its files: transformers, open_clip or ONNX Runtime."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from razer.errors import BadInput
from razer.models.clip.onnx_pair import OnnxPair
from razer.models.clip.towers import Towers
from razer.models.hub.sidecar_files import read_json
from razer.models.runtime.device import Device

_NEEDED_FILES = "config.json of CLIP or SigLIP with its weights, open_clip_config.json, or vision_model.onnx"

Library = Literal["transformers", "open_clip", "onnx"]


def library_of(weights: Path, architecture: str | None) -> Library:
    """Which library runs what lies there; raises BadInput if none does, or if it is not installed."""
    library = _library_of_file(weights, architecture) if weights.is_file() else _library_of_folder(weights)
    if library != "onnx" and find_spec(library) is None:
        raise BadInput(f"{weights} needs the package {library}: pip install 'razer[{library}]'")
    return library


def open_towers(weights: Path, library: Library, architecture: str | None, device: Device) -> Towers:
    """Load both towers.

    Args:
        weights: file or folder of the model.
        library: that runs it, as of library_of.
        architecture: open_clip's MODEL or MODEL:TAG where a file holds weights alone.
        device: auto, cpu or cuda.

    Raises:
        BadInput: where it cannot be loaded.
    """
    if library == "onnx":
        from razer.models.clip.onnx_towers import OnnxTowers

        return OnnxTowers(OnnxPair.at(weights), device)
    if library == "open_clip":
        from razer.models.clip.open_clip_towers import OpenClipTowers

        return OpenClipTowers(weights, architecture, device)
    from razer.models.clip.transformers_towers import TransformersTowers

    return TransformersTowers(weights, device)


def _library_of_file(file: Path, architecture: str | None) -> Library:
    if file.suffix == ".onnx":
        return "onnx"
    if architecture is None:
        raise BadInput(
            f"{file} holds weights alone: set embedder option architecture to open_clip's name of the model, "
            "or weights to a folder"
        )
    return "open_clip"


def _library_of_folder(folder: Path) -> Library:
    config = folder / "config.json"
    settings = read_json(config) if config.is_file() else {}
    has_both_sides = {"vision_config", "text_config"} <= settings.keys()
    if has_both_sides and _has_weights(folder):
        return "transformers"
    if (folder / "open_clip_config.json").is_file():
        return "open_clip"
    if OnnxPair.is_in(folder):
        return "onnx"
    if has_both_sides:
        raise BadInput(f"{folder} describes an image-text model, but has no weights: model.safetensors is missing")
    kind = f" but a {settings['model_type']}" if "model_type" in settings else ""
    raise BadInput(f"{folder} is no image-text model{kind}: it needs {_NEEDED_FILES}")


def _has_weights(folder: Path) -> bool:
    return any(next(folder.glob(name), None) for name in ("model*.safetensors", "pytorch_model*.bin"))
