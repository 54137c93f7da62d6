"""SAM's prompt encoder and mask decoder: points or boxes become masks, by the input names of each export."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput
from razer.models.runtime.onnx_graph import OnnxGraph
from razer.models.sam.promptable import MaskBatches
from razer.models.square_layout import SquareLayout

OBJECT, CORNER, OPPOSITE_CORNER, NO_POINT = 1, 2, 3, -1  # SAM's labels of points
_MASKS = ("low_res_masks", "pred_masks", "masks")  # the first one there is; the last may have the image's size
_SCORES = ("iou_predictions", "iou_scores", "scores")
_NOT_FEATURES = {
    "point_coords", "point_labels", "input_points", "input_labels", "input_boxes", "mask_input", "has_mask_input",
    "orig_im_size",
}  # fmt: skip
_WITH_SINGLE = 4  # of so many masks for one prompt the first is the one for prompts of several points


class SamDecoder:
    """A decoder graph of any of the known exports, for the features of `encoder_outputs`.

    Exports by Meta's own script (also MobileSAM, EdgeSAM) take point_coords (P, K, 2) and point_labels (P, K), those
    by `transformers` input_points (1, P, K, 2) and input_labels (1, P, K). P and K are what the file fixes; where it
    leaves P open, `batch` prompts go at a time. Raises BadInput for other files.
    """

    def __init__(self, graph: OnnxGraph, encoder_outputs: Mapping[str, object], batch: int) -> None:
        self.graph, names = graph, set(graph.inputs)
        self.nested = "input_points" in names
        self.points, self.labels = ("input_points", "input_labels") if self.nested else ("point_coords", "point_labels")
        masks = [name for name in _MASKS if name in graph.outputs]
        scores = [name for name in _SCORES if name in graph.outputs]
        ranks_fit = self.points in names and len(graph.inputs[self.points].shape) == 3 + self.nested
        if not ranks_fit or self.labels not in names or not masks or not scores:
            raise BadInput(
                f"{graph.file} is no SAM decoder: it takes {', '.join(map(str, graph.inputs.values()))} and gives "
                f"{', '.join(map(str, graph.outputs.values()))}"
            )
        self.masks, self.scores = masks[0], scores[0]
        self.features = _matched(graph, names - _NOT_FEATURES, encoder_outputs)
        self.n_prompts, self.n_points = graph.inputs[self.points].shape[-3:-1]  # None where the file leaves it open
        self.batch = self.n_prompts or batch
        # Some graphs add the point that ends a prompt themselves; those of `transformers` unless boxes are an input.
        pads_itself = "high_res_feats_0" in names or (self.nested and "input_boxes" not in names)
        self.pads_points = not pads_itself
        self.pads_boxes = self.nested and not pads_itself
        self.takes_boxes = not self.nested or "input_boxes" in names

    def at_points(self, features: Mapping[str, NDArray], layout: SquareLayout, points: Float64Array) -> MaskBatches:
        """As Promptable."""
        prompts, labels = points[:, None], np.full((len(points), 1), OBJECT)
        for logits, scores in self._run(features, layout, prompts, labels, self.pads_points):
            several = slice(1, None) if logits.shape[1] == _WITH_SINGLE else slice(None)
            yield logits[:, several], scores[:, several]

    def in_boxes(self, features: Mapping[str, NDArray], layout: SquareLayout, boxes: Float64Array) -> MaskBatches:
        """As Promptable."""
        if not self.takes_boxes:
            raise BadInput(f"{self.graph.file} takes points only: leave out option boxes, or use another export")
        labels = np.tile([CORNER, OPPOSITE_CORNER], (len(boxes), 1))
        yield from self._run(features, layout, boxes.reshape(-1, 2, 2), labels, self.pads_boxes)

    def _run(
        self, features: Mapping[str, NDArray], layout: SquareLayout, points: NDArray, labels: NDArray, pad: bool
    ) -> MaskBatches:
        n_points = self.n_points or points.shape[1] + pad
        coordinates = _padded(layout.coordinates(points), n_points, axis=1, value=0)
        labels = _padded(labels, n_points, axis=1, value=NO_POINT)
        inputs = {name: features[source] for name, source in self.features.items()}
        for start in range(0, len(coordinates), self.batch):
            part = slice(start, start + self.batch)
            n = len(coordinates[part])
            size = self.n_prompts or n
            part_coordinates = _padded(coordinates[part], size, axis=0, value=0)
            part_labels = _padded(labels[part], size, axis=0, value=NO_POINT)
            prompts = self._prompts(part_coordinates, part_labels, layout)
            masks, scores = self._masks_and_scores(self.graph({**inputs, **prompts}), size, layout)
            yield masks[:n], scores[:n]

    def _prompts(self, points: NDArray, labels: NDArray, layout: SquareLayout) -> dict[str, NDArray]:
        """The inputs that depend on the prompts, and the empty ones that some exports require."""
        batch_axis = (slice(None),) if not self.nested else (None,)
        inputs = {
            self.points: points[batch_axis],
            self.labels: labels[batch_axis],
            "input_boxes": np.zeros((1, 0, 4)),
            "mask_input": np.zeros(self._mask_shape(len(points), layout)),
            "has_mask_input": np.zeros(1),
            "orig_im_size": np.array([layout.height, layout.width]),
        }
        return {name: array for name, array in inputs.items() if name in self.graph.inputs}

    def _mask_shape(self, n: int, layout: SquareLayout) -> tuple[int, ...]:
        spec = self.graph.inputs.get("mask_input")
        shape = spec.shape if spec else ()
        return (n, 1, *((side or layout.side // 4) for side in shape[2:]))

    def _masks_and_scores(
        self, outputs: Mapping[str, NDArray], n: int, layout: SquareLayout
    ) -> tuple[Float32Array, Float32Array]:
        masks, scores = outputs[self.masks], outputs[self.scores]
        if masks.ndim != 4 + self.nested or masks.shape[-4] != n or scores.shape != masks.shape[:-2]:
            raise BadInput(
                f"{self.graph.file} gives {self.masks} {masks.shape} and {self.scores} {scores.shape} for {n} prompts: "
                "no known SAM decoder does"
            )
        if self.nested:
            masks, scores = masks[0], scores[0]
        of_image = self.masks == "masks" and "orig_im_size" in self.graph.inputs
        return (masks if of_image else layout.filled(masks)), scores


def _padded(array: NDArray, size: int, axis: int, value: int) -> NDArray:
    """The array with `value` behind it along an axis, up to a size."""
    padding = [(0, max(0, size - side) if at == axis else 0) for at, side in enumerate(array.shape)]
    return np.pad(array, padding, constant_values=value)


def _matched(graph: OnnxGraph, required: set[str], offered: Mapping[str, object]) -> dict[str, str]:
    """The output of the encoder that each of the decoder's features is; a single one may have any name."""
    unknown, unused = sorted(required - set(offered)), sorted(set(offered) - required)
    if len(unknown) == 1 and len(unused) == 1:
        return {**{name: name for name in required & set(offered)}, unknown[0]: unused[0]}
    if unknown:
        raise BadInput(
            f"{graph.file} wants {', '.join(unknown)}, and the encoder gives {', '.join(offered)}: "
            "the two files are not of one export"
        )
    return {name: name for name in required}
