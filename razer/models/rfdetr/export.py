"""Signature of an RF-DETR segmentation export: input side, outputs, class names."""

from __future__ import annotations

from dataclasses import dataclass

from razer.errors import BadInput
from razer.models.runtime.onnx_model import OnnxModel
from razer.models.semantic.class_names import KEYS, names_of
from razer.vocabulary import vocabulary

COCO_COLUMNS = 91
"""Columns of a model trained on COCO: they are numbered by COCO's own ids, 1 = person to 90 = toothbrush."""


@dataclass(frozen=True)
class RfDetrExport:
    """Side of the square input in pixels, the place of logits (1, Q, C) and of masks (1, Q, h, w) among the outputs,
    and the name of each column of the logits, '' for those that are no class."""

    side: int
    logits: int
    masks: int
    class_names: tuple[str, ...]

    @classmethod
    def of(cls, model: OnnxModel, names: str | None) -> RfDetrExport:
        """Read from the model, as `export(format="onnx")` of the package rfdetr writes it: "input" (1, 3, S, S),
        "dets" (1, Q, 4), "labels" (1, Q, C), "masks" (1, Q, S/4, S/4).

        Args:
            model: the graph.
            names: a file with the class names, as names_of takes it; None = those of the metadata, else COCO's.

        Raises:
            BadInput: for another signature, and names of another number than the columns.
        """
        rows, columns = model.input.shape[2:] if len(model.input.shape) == 4 else (None, None)
        if rows is None or rows != columns or model.input.shape[:2] not in ((1, 3), (None, 3)):
            raise BadInput(f"{model.file} takes {model.input}, but RF-DETR takes one square colour image 1x3xSxS")
        logits, masks = _logits(model), _only(model, 4)
        return cls(rows, logits, masks, _class_names(model, names, model.outputs[logits].shape[2]))


def _logits(model: OnnxModel) -> int:
    """The place of the logits: the output called labels, else the one beside the boxes."""
    flat = [place for place, output in enumerate(model.outputs) if len(output.shape) == 3]
    named = [place for place in flat if "labels" in model.outputs[place].name]
    other = [place for place in flat if model.outputs[place].shape[2] != 4]
    for places in (named, other):
        if len(places) == 1:
            return places[0]
    raise _unlike(model)


def _only(model: OnnxModel, n_sides: int) -> int:
    places = [place for place, output in enumerate(model.outputs) if len(output.shape) == n_sides]
    if len(places) != 1:
        raise _unlike(model)
    return places[0]


def _unlike(model: OnnxModel) -> BadInput:
    listed = ", ".join(map(str, model.outputs))
    return BadInput(f"{model.file} is no RF-DETR segmentation model: expected dets, labels and masks, not {listed}")


def _class_names(model: OnnxModel, file: str | None, n_columns: int | None) -> tuple[str, ...]:
    has_names = file is not None or any(key.lower() in KEYS for key in model.metadata)
    if not has_names and n_columns == COCO_COLUMNS:
        by_id = vocabulary("coco").by_id
        return tuple(by_id[number].name if number in by_id else "" for number in range(COCO_COLUMNS))
    names = names_of(model.file, model.metadata, file)
    if n_columns in (None, len(names)):
        return names
    if n_columns == len(names) + 1:
        return (*names, "")  # the last column stands for no object
    raise BadInput(f"{model.file} tells {n_columns} columns apart, but {len(names)} names are given")
