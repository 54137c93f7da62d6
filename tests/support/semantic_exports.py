"""ONNX files with the inputs, outputs and metadata of semantic models, which tell classes by colour: red is a chair,
blue is floor, what is neither is wall."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

NAMES = ("other", "wall", "floor", "chair")
# Rows: classes; columns: red, green, blue.
WEIGHTS = np.array([[0, 0, 0], [0, 0, 0], [-1, 0, 1], [1, -1, 0]], np.float32)
BIAS = np.array([-9, 0.5, 0, 0], np.float32)
TYPES = {"float": TensorProto.FLOAT, "half": TensorProto.FLOAT16, "bytes": TensorProto.UINT8}


def write_semantic(
    file: Path,
    *,
    channels_last: bool = False,
    size: tuple[int | str, int | str] = (96, 128),
    takes: str = "float",
    batch: bool = True,
    gives: str = "logits",
    output_type: int = TensorProto.INT32,
    pool: int = 1,
    output_shape: tuple | None = None,
    metadata: dict[str, str] | None = None,
) -> Path:
    """Write such a graph.

    Args:
        file: where to.
        channels_last: whether it takes 1xHxWx3, else 1x3xHxW.
        size: rows and columns of the input; words leave them open.
        takes: float, half or bytes.
        batch: whether input and output begin with a batch of one.
        gives: "logits" 1xCxHxW, "logits last" 1xHxWxC, "classes" 1xHxW, "classes 1" 1x1xHxW, "classes last" 1xHxWx1,
            "probabilities" 1xCxHxW.
        output_type: of class maps.
        pool: pixels of the input that a cell of the output spans along each side.
        output_shape: what the file says of it; None = nothing but how many sides there are.
        metadata: properties of the file; None = the names.
    """
    nodes: list[onnx.NodeProto] = []
    for kind, more, attributes in _steps(channels_last, takes, batch, gives, output_type, pool):
        source = nodes[-1].output[0] if nodes else "image"
        nodes.append(helper.make_node(kind, [source, *more], [f"t{len(nodes)}"], **attributes))
    nodes.append(helper.make_node("Identity", [nodes[-1].output[0]], ["classes"]))
    image = (*size, 3) if channels_last else (3, *size)
    n_sides = (3 if gives == "classes" else 4) - (not batch)
    shape = output_shape or tuple(f"side {i}" for i in range(n_sides))
    given = output_type if gives.startswith("classes") else TensorProto.FLOAT
    constants = {
        "first": np.array([0]), "white": np.array(255, np.float32),
        "weights": WEIGHTS[:, :, None, None], "bias": BIAS,
    }  # fmt: skip
    graph = helper.make_graph(
        nodes,
        "semantic",
        [helper.make_tensor_value_info("image", TYPES[takes], (1, *image) if batch else image)],
        [helper.make_tensor_value_info("classes", given, shape)],
        [numpy_helper.from_array(array, name) for name, array in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    helper.set_model_props(model, {"names": str(dict(enumerate(NAMES)))} if metadata is None else metadata)
    onnx.save(model, str(file))
    return file


def _steps(
    channels_last: bool, takes: str, batch: bool, gives: str, output_type: int, pool: int
) -> list[tuple[str, list[str], dict[str, object]]]:
    """Operators from image to classes, with their constants and attributes."""
    to_last: tuple = ("Transpose", [], {"perm": [0, 2, 3, 1]})
    steps = {
        "Unsqueeze": (not batch, ["first"], {}),
        "Cast": (True, [], {"to": TensorProto.FLOAT}),
        "Div": (takes == "bytes", ["white"], {}),
        "Transpose": (channels_last, [], {"perm": [0, 3, 1, 2]}),
        "Conv": (True, ["weights", "bias"], {}),
        "AveragePool": (pool > 1, [], {"kernel_shape": [pool, pool], "strides": [pool, pool]}),
        "Softmax": (gives == "probabilities", [], {"axis": 1}),
        "ArgMax": (gives.startswith("classes"), [], {"axis": 1, "keepdims": int(gives != "classes")}),
    }
    done = [(kind, more, attributes) for kind, (wanted, more, attributes) in steps.items() if wanted]
    done += [to_last] if gives.endswith("last") else []
    done += [("Cast", [], {"to": output_type})] if gives.startswith("classes") else []
    return done + ([] if batch else [("Squeeze", ["first"], {})])
