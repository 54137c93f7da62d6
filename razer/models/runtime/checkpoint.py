"""Checkpoints of the `transformers` library: folders that its `save_pretrained` writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from razer.errors import BadInput
from razer.files import read_json
from razer.models.hub.model_file import model_file
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device
from razer.models.square_layout import DEVIATION, MEAN

_HALF = (0.5, 0.5, 0.5)  # SAM 3's default
_PREPROCESSING = ("preprocessor_config.json", "processor_config.json")


@dataclass(frozen=True)
class Checkpoint:
    """A folder with config.json and weights; it is read and checked, but nothing is loaded."""

    folder: Path
    config: Mapping[str, Any]

    @classmethod
    def of(cls, weights: str | Path) -> Checkpoint:
        """The checkpoint at a path, or of a name of the catalogue or the hub that is in the cache; raises BadInput."""
        folder = model_file(weights)
        if find_spec("transformers") is None:
            raise BadInput("this model needs the transformers library: pip install 'razer[transformers]'")
        if not (folder / "config.json").is_file():
            raise BadInput(f"{folder} is no checkpoint: it should be a folder with config.json and model.safetensors")
        files = [*folder.glob("*.safetensors"), *folder.glob("pytorch_model*.bin")]
        if not files:
            raise BadInput(f"{folder} has no weights: model.safetensors is missing")
        for file in files:
            _check_whole(file)
        return cls(folder, read_json(folder / "config.json"))

    @property
    def kind(self) -> str:
        """The library's name of the architecture, such as sam2; empty if the file has none."""
        return str(self.config.get("model_type", ""))

    def colours(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Mean and standard deviation that its images are normalised with, of colours in [0, 1]."""
        settings: dict[str, Any] = {}
        for name in _PREPROCESSING:
            if not settings and (self.folder / name).is_file():
                settings = read_json(self.folder / name)
        settings = settings.get("image_processor", settings)
        mean, deviation = (_HALF, _HALF) if self.kind.startswith("sam3") else (MEAN, DEVIATION)
        return tuple(settings.get("image_mean", mean)), tuple(settings.get("image_std", deviation))

    def load(self, loader: str, device: Device) -> Any:
        """The model, by one of the library's classes, ready to compute on the device; raises BadInput."""
        model, info = self._from_pretrained(loader, output_loading_info=True)
        if missing := info["missing_keys"]:
            raise BadInput(
                f"{self.folder} lacks {len(missing)} weights, such as {min(missing)}: "
                "it was saved from another kind of model"
            )
        return model.eval().to(torch_device(device))

    def part(self, loader: str, **options: Any) -> Any:
        """A processor or tokenizer, by one of the library's classes; raises BadInput."""
        return self._from_pretrained(loader, **options)

    def _from_pretrained(self, loader: str, **options: Any) -> Any:
        import transformers  # late: it takes seconds
        from safetensors import SafetensorError

        transformers.utils.logging.set_verbosity_error()
        transformers.utils.logging.disable_progress_bar()
        try:
            # Code that a checkpoint brings along is never run, nor is anybody asked whether to.
            options |= {"local_files_only": True, "trust_remote_code": False}
            return getattr(transformers, loader).from_pretrained(self.folder, **options)
        except (OSError, ValueError, KeyError, RuntimeError, ImportError, TypeError, SafetensorError) as error:
            first = next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)
            raise BadInput(f"{self.folder} cannot be loaded as {loader}: {first}") from error


def _check_whole(file: Path) -> None:
    """Refuse a file in safetensors format, which records its own length, that is cut short."""
    from safetensors import SafetensorError, safe_open

    if file.suffix != ".safetensors":
        return
    try:
        with safe_open(file, "pt"):
            pass
    except (OSError, SafetensorError) as error:
        raise BadInput(f"{file} is damaged or cut short: {error}") from error
