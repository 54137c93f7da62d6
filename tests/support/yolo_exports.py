"""ONNX files with the inputs, outputs and metadata of YOLO exports, whose masks are where an image is red."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

THRESHOLD = 1 / 3  # red less green from which on a picture is red
GRID = 4  # pixels of the input that a cell of the prototypes spans
COCO80 = {i: f"class {i}" for i in range(80)} | {56: "chair", 41: "cup"}


def dense(n_anchors: int, detections: list[tuple], n_classes: int = 80, n_prototypes: int = 32) -> np.ndarray:
    """Predictions (1, 4 + classes + M, anchors) of (x1, y1, x2, y2, score, class)."""
    rows = np.zeros((1, 4 + n_classes + n_prototypes, n_anchors), np.float32)
    for anchor, (x1, y1, x2, y2, score, number) in enumerate(detections):
        rows[0, :4, anchor] = (x1 + x2) / 2, (y1 + y2) / 2, x2 - x1, y2 - y1
        rows[0, 4 + number, anchor] = score
        rows[0, 4 + n_classes, anchor] = 1
    return rows


def end_to_end(n_rows: int, detections: list[tuple], n_prototypes: int = 32) -> np.ndarray:
    """Predictions (1, N, 6 + M) of (x1, y1, x2, y2, score, class)."""
    rows = np.zeros((1, n_rows, 6 + n_prototypes), np.float32)
    for row, values in enumerate(detections):
        rows[0, row, :6] = values
        rows[0, row, 6] = 1
    return rows


def write_export(
    file: Path,
    predictions: np.ndarray,
    *,
    input_shape: tuple = (1, 3, 640, 640),
    output_shapes: tuple | None = None,
    n_prototypes: int = 32,
    half: bool = False,
    metadata: dict[str, str] | None = None,
    drop_prototypes: bool = False,
) -> Path:
    """Write a graph that gives `predictions`, and prototypes of which the first is red minus green. Sides given as
    words are left open."""
    kind, dtype = (TensorProto.FLOAT16, np.float16) if half else (TensorProto.FLOAT, np.float32)
    channels = input_shape[1] if isinstance(input_shape[1], int) else 3
    weights = np.zeros((n_prototypes, channels, GRID, GRID), dtype)
    weights[0, 0], weights[0, 1 % channels] = 1 / GRID**2, -1 / GRID**2
    cells = [side // GRID if isinstance(side, int) else f"cells_{side}" for side in input_shape[2:]]
    shapes = output_shapes or (predictions.shape, (input_shape[0], n_prototypes, *cells))
    # Sides that are cut at what is known of the input only when the graph runs are open.
    nodes = [
        helper.make_node("Shape", ["images"], ["sides"], start=2),
        helper.make_node("Mul", ["sides", "plenty"], ["ends"]),
        helper.make_node("Slice", ["predictions", "starts", "ends", "axes"], ["output0"]),
    ]
    outputs = [helper.make_tensor_value_info("output0", kind, shapes[0])]
    if not drop_prototypes:
        nodes.append(helper.make_node("Conv", ["images", "weights", "bias"], ["output1"], strides=[GRID, GRID]))
        outputs.append(helper.make_tensor_value_info("output1", kind, shapes[1]))
    constants = {
        "predictions": predictions.astype(dtype),
        "weights": weights,
        "bias": np.full(n_prototypes, -THRESHOLD, dtype),
        "plenty": np.array([10**6, 10**6]),
        "starts": np.array([0, 0]),
        "axes": np.array([1, 2]),
    }
    graph = helper.make_graph(
        nodes,
        "yolo",
        [helper.make_tensor_value_info("images", kind, input_shape)],
        outputs,
        [numpy_helper.from_array(array, name) for name, array in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    properties = {"task": "segment", "stride": "32", "names": str(COCO80)} if metadata is None else metadata
    helper.set_model_props(model, properties)
    onnx.save(model, str(file))
    return file
