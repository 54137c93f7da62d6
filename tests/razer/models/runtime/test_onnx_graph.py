"""ONNX files as functions: types, errors, and the way to another process."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import onnx.parser
import onnxruntime
import pytest

from razer.errors import BadInput
from razer.models.runtime import onnx_session
from razer.models.runtime.onnx_graph import OnnxGraph


def written(folder: Path, text: str) -> Path:
    file = folder / "graph.onnx"
    onnx.save(onnx.parser.parse_model('<ir_version: 8, opset_import: ["" : 17]>\n' + text), file)
    return file


HALVES = "g (float16[N,3] a, int64[N] b) => (float16[N,3] c, int64[N] d) { c = Add(a, a) d = Neg(b) }"


def test_numbers_are_brought_to_the_types_of_the_graph(tmp_path: Path) -> None:
    graph = OnnxGraph(written(tmp_path, HALVES), "cpu")
    assert {name: port.shape for name, port in graph.inputs.items()} == {"a": (None, 3), "b": (None,)}
    for _ in range(2):  # before and after the session was opened
        outputs = graph({"a": np.full((2, 3), 1.5), "b": np.array([1.0, 2.0])})
        assert outputs["c"].dtype == np.float32
        assert outputs["c"].tolist() == [[3.0] * 3] * 2
        assert outputs["d"].tolist() == [-1, -2]
        graph = pickle.loads(pickle.dumps(graph))


def test_shapes_it_does_not_take_are_one_line(tmp_path: Path) -> None:
    graph = OnnxGraph(written(tmp_path, HALVES), "cpu")
    with pytest.raises(BadInput, match=r"cannot compute a 2x4, b 2: ") as caught:
        graph({"a": np.zeros((2, 4)), "b": np.zeros(2)})
    assert "\n" not in str(caught.value)


def test_inputs_no_model_takes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"takes a \? as tensor\(string\)"):
        OnnxGraph(written(tmp_path, "g (string[N] a) => (string[N] c) { c = Identity(a) }"))


@pytest.mark.parametrize("content", [b"", b"not a graph"])
def test_what_is_no_graph_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "graph.onnx").write_bytes(content)
    with pytest.raises(BadInput, match="is no ONNX model, or is damaged"):
        OnnxGraph(tmp_path / "graph.onnx")


def test_cuda_is_taken_where_there_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written(tmp_path, HALVES)
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: [onnx_session.CPU])
    with pytest.raises(BadInput, match="no CUDA"):
        OnnxGraph(file, "cuda")
    assert OnnxGraph(file, "auto").providers == [onnx_session.CPU]
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: [onnx_session.CUDA, onnx_session.CPU])
    assert OnnxGraph(file, "auto").providers == [onnx_session.CUDA, onnx_session.CPU]
    assert OnnxGraph(file, "cpu").providers == [onnx_session.CPU]


def test_the_runtime_keeps_no_record_of_its_use(tmp_path: Path) -> None:
    """Where it may tell of its use, it makes a number for this machine and a database of events at once."""
    home, file = tmp_path / "home", written(tmp_path, HALVES)
    home.mkdir()
    code = f"from razer.models.runtime.onnx_graph import OnnxGraph; OnnxGraph({str(file)!r}, 'cpu')"
    kept = {"ORT_DISABLE_TELEMETRY", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"}
    environment = {key: value for key, value in os.environ.items() if key not in kept} | {"HOME": str(home)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True, timeout=100)
    assert list(home.rglob("*")) == []
