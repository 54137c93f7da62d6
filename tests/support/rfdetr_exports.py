"""ONNX files with the inputs and outputs of RF-DETR segmentation exports, as https://huggingface.co/besit/rfdetr-onnx
lists them; the first query's mask is where an image is red, the second's where it is blue."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

CHAIR, CUP, TOOTHBRUSH = 62, 47, 90  # COCO's own numbers
GRID = 4  # pixels of the input that a cell of the masks spans
MEAN, STD = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])
THRESHOLD = 1 / 3  # a colour less green from which on a picture has it


def logits(queries: list[dict[int, float]], n_columns: int = 91) -> np.ndarray:
    """Logits (1, Q, C): of each query the probabilities of some columns, of the others 0.01."""
    probabilities = np.full((1, len(queries), n_columns), 0.01)
    for query, given in enumerate(queries):
        for column, probability in given.items():
            probabilities[0, query, column] = probability
    return np.log(probabilities / (1 - probabilities)).astype(np.float32)


def write_rfdetr(
    file: Path,
    labels: np.ndarray,
    *,
    side: int | str = 64,
    names: tuple[str, str, str] = ("dets", "labels", "masks"),
    drop_masks: bool = False,
    metadata: dict[str, str] | None = None,
) -> Path:
    """Write a graph that gives `labels`; a side given as a word is left open."""
    n_queries = labels.shape[1]
    weights, bias = np.zeros((n_queries, 3, GRID, GRID)), np.full(n_queries, -9.0)
    for query, channel in enumerate((0, 2)[:n_queries]):
        # colour = normalised * std + mean, here and in green
        weights[query, channel], weights[query, 1] = STD[channel] / GRID**2, -STD[1] / GRID**2
        bias[query] = MEAN[channel] - MEAN[1] - THRESHOLD
    cells = side // GRID if isinstance(side, int) else "cells"
    nodes = [
        helper.make_node("Identity", ["boxes"], [names[0]]),
        helper.make_node("Identity", ["logits"], [names[1]]),
        helper.make_node("Conv", ["input", "weights", "bias"], [names[2]], strides=[GRID, GRID]),
    ]
    shapes = [(1, n_queries, 4), labels.shape, (1, n_queries, cells, cells)]
    outputs = [helper.make_tensor_value_info(n, TensorProto.FLOAT, s) for n, s in zip(names, shapes, strict=True)]
    kept = 2 if drop_masks else 3
    constants = {"boxes": np.full(shapes[0], 0.5), "logits": labels, "weights": weights, "bias": bias}
    graph = helper.make_graph(
        nodes[:kept],
        "rfdetr",
        [helper.make_tensor_value_info("input", TensorProto.FLOAT, (1, 3, side, side))],
        outputs[:kept],
        [numpy_helper.from_array(array.astype(np.float32), name) for name, array in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    helper.set_model_props(model, metadata or {})
    onnx.save(model, str(file))
    return file
