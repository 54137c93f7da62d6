"""The embedder clip with ONNX pairs: exports of tiny checkpoints, and hand-made graphs of other signatures."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from razer.errors import BadInput
from razer.models.clip.embedder import ClipEmbedder
from razer.models.mask_pooling import pool_masks
from tests.support import clip_checkpoints as tiny

onnx = pytest.importorskip("onnx")
helper, numpy_helper = onnx.helper, onnx.numpy_helper
FLOAT, FLOAT16, INT32, INT64 = (getattr(onnx.TensorProto, kind) for kind in ("FLOAT", "FLOAT16", "INT32", "INT64"))
TEXTS = ["a red chair", "table", "A photo of the table ."]
MAKERS = {"clip": tiny.clip_folder, "siglip": tiny.siglip_folder}


@pytest.fixture(scope="module", params=MAKERS)
def pair(request, tmp_path_factory):
    """The folder of a checkpoint, and that of its export."""
    source = MAKERS[request.param](tmp_path_factory.mktemp("torch"))
    return source, tiny.onnx_folder(tmp_path_factory.mktemp("export"), source)


@pytest.fixture(scope="module")
def frame():
    return tiny.colourful_frame()


@pytest.fixture(scope="module")
def masks():
    return tiny.overlapping_masks()


def saved(path, taken, given, nodes, weights=()):
    """Write a graph: inputs and outputs as (name, type, shape), weights as name -> array."""
    ports = [[helper.make_tensor_value_info(*port) for port in side] for side in (taken, given)]
    tensors = [numpy_helper.from_array(array, name) for name, array in dict(weights).items()]
    graph = helper.make_graph(nodes, "tower", *ports, tensors)
    path.parent.mkdir(parents=True, exist_ok=True)
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10), path)
    return path


def with_preprocessor(folder, **changes):
    config = {"image_mean": [0, 0, 0], "image_std": [1, 1, 1], "size": 32, **changes}
    (folder / "preprocessor_config.json").write_text(json.dumps(config))


def means_of_colours(path, kind=FLOAT, batch="batch"):
    """An image tower whose vector is the mean of each colour."""
    pool = helper.make_node("GlobalAveragePool", ["pixel_values"], ["pooled"])
    flat = helper.make_node("Flatten", ["pooled"], ["image_embeds"])
    taken, given = ("pixel_values", kind, [batch, 3, "h", "w"]), ("image_embeds", kind, [batch, 3])
    return saved(path, [taken], [given], [pool, flat])


def test_onnx_and_torch_agree(pair, frame, masks):
    source, export = pair
    by_torch, by_onnx = ClipEmbedder(source), ClipEmbedder(export)
    np.testing.assert_allclose(by_onnx.embed(frame, masks), by_torch.embed(frame, masks), atol=1e-4)
    np.testing.assert_allclose(by_onnx.embed_texts(TEXTS), by_torch.embed_texts(TEXTS), atol=1e-4)
    region = [e.embed_region(frame.rgb, masks.masks[0]) for e in (by_onnx, by_torch)]
    np.testing.assert_allclose(*region, atol=1e-4)


def test_exports_for_a_single_row(tmp_path, frame, masks):
    source = tiny.clip_folder(tmp_path / "torch")
    export = ClipEmbedder(tiny.onnx_folder(tmp_path / "export", source, batch=False))
    np.testing.assert_allclose(export.embed(frame, masks), ClipEmbedder(source).embed(frame, masks), atol=1e-4)
    np.testing.assert_allclose(export.embed_texts(TEXTS), ClipEmbedder(source).embed_texts(TEXTS), atol=1e-4)


def test_a_file_names_the_pair(pair, tmp_path, frame, masks):
    export = shutil.copytree(pair[1], tmp_path / "export")
    (export / "onnx" / "vision_model.onnx").rename(export / "onnx" / "vision_model_fp32.onnx")
    (export / "onnx" / "text_model.onnx").rename(export / "onnx" / "text_model_fp32.onnx")
    embedder = ClipEmbedder(export / "onnx" / "vision_model_fp32.onnx")
    np.testing.assert_array_equal(embedder.embed(frame, masks), ClipEmbedder(pair[1]).embed(frame, masks))
    np.testing.assert_array_equal(embedder.embed_texts(TEXTS), ClipEmbedder(pair[1]).embed_texts(TEXTS))


@pytest.mark.parametrize("kind", [FLOAT, FLOAT16])
def test_colours_are_scaled_as_the_files_say(tmp_path, kind):
    means_of_colours(tmp_path / "visual.onnx", kind)
    with_preprocessor(tmp_path, image_mean=[0.5, 0, 0], image_std=[0.5, 1, 0.5])
    rgb = np.empty((20, 20, 3), np.uint8)
    rgb[:] = (51, 102, 204)
    expected = np.array([(0.2 - 0.5) / 0.5, 0.4, 0.8 / 0.5])
    vector = ClipEmbedder(tmp_path, crop_scale=1).embed_region(rgb, np.ones((20, 20), bool))
    np.testing.assert_allclose(vector, expected / np.linalg.norm(expected), atol=1e-3 if kind == FLOAT16 else 1e-6)


@pytest.mark.parametrize(
    "config",
    [
        {"do_normalize": False, "image_mean": [0.9, 0.9, 0.9], "size": {"shortest_edge": 32}},
        {"image_processor": {"image_mean": [0, 0, 0], "image_std": [1, 1, 1], "size": {"height": 32, "width": 32}}},
        {"mean": [0, 0, 0], "std": [1, 1, 1], "size": [32, 32]},
        {"image_mean": [0, 0, 0], "image_std": [1, 1, 1], "size": 40, "crop_size": 32},
    ],
)
@pytest.mark.parametrize("file", ["preprocessor_config.json", "processor_config.json", "preprocess_cfg.json"])
def test_the_ways_libraries_describe_pictures(tmp_path, config, file):
    means_of_colours(tmp_path / "vision_model.onnx")
    (tmp_path / file).write_text(json.dumps(config))
    wanted = ClipEmbedder(tmp_path)._towers.image_input
    assert (wanted.size, tuple(wanted.mean), tuple(wanted.std)) == (32, (0, 0, 0), (1, 1, 1))


def test_dense_features_of_a_model_made_for_it(tmp_path, frame, masks):
    """A graph with features at each pixel: each colour's mean in cells of 8 pixels."""
    nodes = [helper.make_node("AveragePool", ["image"], ["features"], kernel_shape=[8, 8], strides=[8, 8])]
    taken, given = ("image", FLOAT, [1, 3, 32, 32]), ("features", FLOAT, [1, 3, 4, 4])
    saved(tmp_path / "vision_model.onnx", [taken], [given], nodes)
    with_preprocessor(tmp_path)
    rgb = np.ascontiguousarray(frame.rgb[:32, :32])
    cells = rgb.reshape(4, 8, 4, 8, 3).mean(axis=(1, 3)).astype(np.float32)
    expected = pool_masks(cells, masks.masks[:1, :32, :32])[0]
    vector = ClipEmbedder(tmp_path, vectors="dense").embed_region(rgb, masks.masks[0, :32, :32])
    np.testing.assert_allclose(vector, expected / np.linalg.norm(expected), atol=1e-5)
    with pytest.raises(BadInput, match="does not give one vector for each row"):
        ClipEmbedder(tmp_path).embed(frame, masks)


def test_padding_is_told_to_graphs_that_ask_and_numbers_may_be_short(tmp_path):
    """A text tower that adds up the vectors of words: padding must not be among them."""
    table = np.random.default_rng(0).normal(size=(32, 3)).astype(np.float32)
    nodes = [
        helper.make_node("Gather", ["table", "input_ids"], ["vectors"]),
        helper.make_node("Cast", ["attention_mask"], ["count"], to=FLOAT),
        helper.make_node("Unsqueeze", ["count", "last"], ["shares"]),
        helper.make_node("Mul", ["vectors", "shares"], ["words"]),
        helper.make_node("ReduceSum", ["words", "axis"], ["sum"], keepdims=0),
    ]
    taken = [("input_ids", INT32, ["batch", "n"]), ("attention_mask", INT64, ["batch", "n"])]
    weights = {"table": table, "last": np.array([2], np.int64), "axis": np.array([1], np.int64)}
    saved(tmp_path / "text_model.onnx", taken, [("sum", FLOAT, ["batch", 3])], nodes, weights)
    means_of_colours(tmp_path / "vision_model.onnx")
    with_preprocessor(tmp_path)
    source = tiny.siglip_folder(tmp_path / "torch")
    for file in ("tokenizer.json", "tokenizer_config.json"):
        shutil.copy(source / file, tmp_path / file)
    words = {"red": 4, "chair": 5, "end": 1}
    expected = table[list(words.values())].sum(axis=0)
    vector = ClipEmbedder(tmp_path).embed_texts(["Red chair"])[0]
    np.testing.assert_allclose(vector, expected / np.linalg.norm(expected), atol=1e-6)


def test_a_model_without_text_tower_still_embeds_but_knows_no_words(pair, tmp_path, frame, masks):
    export = shutil.copytree(pair[1], tmp_path / "export")
    (export / "onnx" / "text_model.onnx").unlink()
    embedder = ClipEmbedder(export)
    np.testing.assert_array_equal(embedder.embed(frame, masks), ClipEmbedder(pair[1]).embed(frame, masks))
    with pytest.raises(BadInput, match=r"vision_model\.onnx has no text tower beside it"):
        embedder.embed_texts(TEXTS)


def truncated(file):
    file.write_bytes(file.read_bytes()[:500])


def swapped(export):
    image, text = export / "onnx" / "vision_model.onnx", export / "onnx" / "text_model.onnx"
    shutil.copy(text, image)


SPOILT = [
    (lambda e: truncated(e / "onnx" / "vision_model.onnx"), r"vision_model\.onnx is no ONNX model, or is damaged"),
    (swapped, r"vision_model\.onnx does not take pictures"),
    (lambda e: (e / "preprocessor_config.json").unlink(), r"no preprocessor_config\.json beside it"),
    (lambda e: (e / "preprocessor_config.json").write_text("{"), r"preprocessor_config\.json cannot be read"),
    (lambda e: (e / "preprocessor_config.json").write_text("[1]"), "is not a JSON object"),
    (lambda e: (e / "preprocessor_config.json").write_text("{}"), "does not say the"),
]
SPOILT_TEXT = [
    (lambda e: truncated(e / "onnx" / "text_model.onnx"), r"text_model\.onnx is no ONNX model, or is damaged"),
    (
        lambda e: shutil.copy(e / "onnx" / "vision_model.onnx", e / "onnx" / "text_model.onnx"),
        r"text_model\.onnx does not take token numbers",
    ),
    (lambda e: (e / "tokenizer.json").unlink(), r"no tokenizer\.json beside it"),
    (lambda e: truncated(e / "tokenizer.json"), r"tokenizer\.json is no tokenizer"),
]


@pytest.mark.parametrize(("spoil", "message"), SPOILT)
def test_spoilt_image_side_is_one_line(pair, tmp_path, frame, masks, spoil, message):
    export = shutil.copytree(pair[1], tmp_path / "export")
    spoil(export)
    with pytest.raises(BadInput, match=message) as caught:
        ClipEmbedder(export).embed(frame, masks)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("spoil", "message"), SPOILT_TEXT)
def test_spoilt_text_side_is_one_line(pair, tmp_path, spoil, message):
    export = shutil.copytree(pair[1], tmp_path / "export")
    spoil(export)
    with pytest.raises(BadInput, match=message) as caught:
        ClipEmbedder(export).embed_texts(TEXTS)
    assert "\n" not in str(caught.value)


def test_both_towers_in_one_graph_are_refused(tmp_path, frame, masks):
    taken = [("pixel_values", FLOAT, ["n", 3, 32, 32]), ("input_ids", INT64, ["m", "length"])]
    nodes = [helper.make_node("Flatten", ["pixel_values"], ["image_embeds"])]
    saved(tmp_path / "vision_model.onnx", taken, [("image_embeds", FLOAT, ["n", 3072])], nodes)
    with_preprocessor(tmp_path)
    with pytest.raises(BadInput, match="also wants input_ids: give an export with one graph per tower"):
        ClipEmbedder(tmp_path).embed(frame, masks)


def test_what_an_export_cannot_give(pair, frame, masks):
    with pytest.raises(BadInput, match=r"features at each pixel.*set embedder option vectors to crops"):
        ClipEmbedder(pair[1], vectors="dense").embed(frame, masks)
    with pytest.raises(BadInput, match="set embedder option vectors to crops or dense"):
        ClipEmbedder(pair[1], vectors="tokens").embed(frame, masks)


def test_towers_of_different_models(pair, tmp_path):
    export = shutil.copytree(pair[1], tmp_path / "export")
    means_of_colours(export / "onnx" / "vision_model.onnx")
    with pytest.raises(BadInput, match="are of different models: their vectors differ in length"):
        ClipEmbedder(export).embed_texts(TEXTS)


def test_pictures_of_a_size_the_graph_does_not_take(tmp_path, frame, masks):
    weights = {"matrix": np.ones((3072, 4), np.float32)}
    nodes = [
        helper.make_node("Flatten", ["pixel_values"], ["flat"]),
        helper.make_node("MatMul", ["flat", "matrix"], ["image_embeds"]),
    ]
    taken, given = ("pixel_values", FLOAT, ["n", 3, "h", "w"]), ("image_embeds", FLOAT, ["n", 4])
    saved(tmp_path / "vision_model.onnx", [taken], [given], nodes, weights)
    with_preprocessor(tmp_path, size=40)
    with pytest.raises(BadInput, match=r"vision_model\.onnx cannot compute an input of 5x3x40x40"):
        ClipEmbedder(tmp_path).embed(frame, masks)
