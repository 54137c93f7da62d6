"""Metadata of a YOLO segmentation export: outputs, class names, input size."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

from razer.errors import BadInput
from razer.models.runtime.onnx_model import OnnxModel
from razer.models.yolo.letterbox import Letterbox, Shape


@dataclass(frozen=True)
class YoloExport:
    """The place of predictions and prototypes among the outputs; class_names where the file has them; and the input
    (rows, columns), where a side with a stride may also be smaller, by whole strides."""

    predictions: int
    prototypes: int
    class_names: tuple[str, ...] | None
    input: Shape
    stride: tuple[int | None, int | None]

    @classmethod
    def of(cls, model: OnnxModel, size: int | None) -> YoloExport:
        """Read from the model; `size` is the longest side in pixels where the model leaves it open. Raises BadInput."""
        task = model.metadata.get("task", "segment")
        if task != "segment":
            raise BadInput(f"{model.file} is a model to {task}: give one to segment, such as yolo11n-seg.onnx")
        predictions, prototypes = (_only_output(model, sides) for sides in (3, 4))
        return cls(predictions, prototypes, _class_names(model), *_input(model, size))

    def letterbox(self, image: Shape) -> Letterbox:
        """How an image (rows, columns) is fitted into the input."""
        return Letterbox.of(image, self.input, self.stride)


def _only_output(model: OnnxModel, n_sides: int) -> int:
    matching = [i for i, output in enumerate(model.outputs) if len(output.shape) == n_sides]
    if len(matching) != 1:
        listed = ", ".join(map(str, model.outputs))
        raise BadInput(f"{model.file} is no YOLO segmentation model: expected predictions and prototypes, not {listed}")
    return matching[0]


def _class_names(model: OnnxModel) -> tuple[str, ...] | None:
    names = _literal(model, "names", None)
    if isinstance(names, list):
        names = dict(enumerate(names))
    if names is None:
        return None
    if isinstance(names, dict) and set(names) == set(range(len(names))):
        return tuple(str(names[number]) for number in range(len(names)))
    raise BadInput(f"{model.file}: its metadata 'names' should number the classes from 0, as in {{0: 'chair'}}")


def _input(model: OnnxModel, size: int | None) -> tuple[Shape, tuple[int | None, int | None]]:
    """Rows and columns of the input, and the strides of those sides that the model leaves open."""
    spec = model.input
    if len(spec.shape) != 4 or spec.shape[0] not in (None, 1) or spec.shape[1] not in (None, 3):
        raise BadInput(f"{model.file} takes {spec}, not one colour image 1x3xHxW")
    fixed = spec.shape[2:]
    if size is not None and (size < 1 or None not in fixed):
        raise BadInput(f"option size = {size}: it is for models that leave it open, and {model.file} takes {spec}")
    usual = _whole_numbers(model, "imgsz", 640) if size is None else (size, size)
    stride = _whole_numbers(model, "stride", 32)
    # A model that leaves a side open still takes whole strides only.
    rows, columns = (
        side or -(-longest // step) * step for side, longest, step in zip(fixed, usual, stride, strict=True)
    )
    steps = [None if side else step for side, step in zip(fixed, stride, strict=True)]
    return (rows, columns), (steps[0], steps[1])


def _whole_numbers(model: OnnxModel, key: str, default: int) -> tuple[int, int]:
    """Metadata for rows and columns, written as one number for both or as two."""
    value = _literal(model, key, default)
    pair = (value, value) if isinstance(value, int) else value
    if isinstance(pair, list | tuple) and len(pair) == 2 and all(isinstance(n, int) and n > 0 for n in pair):
        return pair[0], pair[1]
    raise BadInput(f"{model.file}: its metadata '{key}' is {value!r}, expected one or two whole numbers")


def _literal(model: OnnxModel, key: str, default: Any) -> Any:
    """Metadata written as a Python value."""
    if key not in model.metadata:
        return default
    text = model.metadata[key]
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError) as error:
        raise BadInput(f"{model.file}: its metadata '{key}' cannot be read: {text[:40]!r}") from error
