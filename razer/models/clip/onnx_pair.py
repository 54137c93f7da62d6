"""Image and text graphs of an image-text model exported to ONNX."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from razer.errors import BadInput

# As exports for transformers.js and of open_clip name them.
_IN_FOLDER = (
    ("vision_model.onnx", "text_model.onnx"),
    ("onnx/vision_model.onnx", "onnx/text_model.onnx"),
    ("visual.onnx", "textual.onnx"),
    ("visual/model.onnx", "textual/model.onnx"),
)
_NAMES = (("vision", "text"), ("visual", "textual"), ("image", "text"))


@dataclass(frozen=True)
class OnnxPair:
    """Image tower and text tower; None where there is no text tower."""

    image: Path
    text: Path | None

    @classmethod
    def at(cls, weights: Path) -> OnnxPair:
        """The pair in a folder, or of the image tower's file; raises BadInput."""
        if weights.is_file():
            return cls(weights, _text_beside(weights))
        for image, text in _IN_FOLDER:
            if (weights / image).is_file():
                return cls(weights / image, weights / text if (weights / text).is_file() else None)
        raise BadInput(f"{weights} has no vision_model.onnx: set embedder option weights to the image tower's file")

    @classmethod
    def is_in(cls, folder: Path) -> bool:
        """Whether the folder has an image tower under a usual name."""
        return any((folder / image).is_file() for image, _ in _IN_FOLDER)


def _text_beside(image: Path) -> Path | None:
    """The text tower where the names differ in one word only: "x-visual.onnx", "x-textual.onnx"."""
    for image_word, text_word in _NAMES:
        text = image.with_name(image.name.replace(image_word, text_word))
        if text != image and text.is_file():
            return text
    return None
