"""The semantic segmenter on ONNX files of each signature, on files that are none, and on real frames."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import cv2
import numpy as np
import pytest
from onnx import TensorProto

from data_tools import open_sequence
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.models import make_segmenter
from razer.models.semantic.networks import OnnxNetwork
from razer.models.semantic.segmenter import SemanticSegmenter
from tests.support.semantic_exports import NAMES, write_semantic

CHAIRS = (slice(30, 60), slice(10, 40)), (slice(24, 66), slice(70, 100))  # rows and columns at 96x128
FLOOR = (slice(66, 96), slice(0, 128))
SIGNATURES = {
    "NCHW, logits": {},
    "NHWC, bytes, classes": {"channels_last": True, "takes": "bytes", "gives": "classes"},
    "NCHW, bytes": {"takes": "bytes"},
    "NHWC, half": {"channels_last": True, "takes": "half"},
    "logits last": {"gives": "logits last"},
    "probabilities": {"gives": "probabilities"},
    "classes 1xHxWx1": {"gives": "classes last", "output_type": TensorProto.INT64},
    "classes 1x1xHxW": {"gives": "classes 1", "output_type": TensorProto.UINT8},
    "classes of floats": {"gives": "classes", "output_type": TensorProto.FLOAT},
    "no batch": {"batch": False},
    "no batch, classes": {"batch": False, "gives": "classes", "channels_last": True},
    "no batch, logits last": {"batch": False, "gives": "logits last"},
    "quarter of the size": {"pool": 4},
    "classes at a half": {"pool": 2, "gives": "classes"},
    "open": {"size": ("h", "w")},
    "square": {"size": (128, 128)},
    "shape known": {"output_shape": (1, 4, 96, 128)},
}


def picture(width: int = 128, height: int = 96) -> Frame:
    """A grey wall, a blue floor, and two red chairs that do not touch."""
    rgb = np.full((96, 128, 3), 120, np.uint8)
    rgb[FLOOR] = (30, 60, 200)
    for chair in CHAIRS:
        rgb[chair] = (200, 30, 60)
    rgb = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_NEAREST)
    return Frame(0, 0.0, rgb, np.ones((height, width), np.float32), Intrinsics(width, height, 90, 90, 64, 48))


def truth(frame: Frame) -> list[tuple[str, np.ndarray]]:
    red, blue = frame.rgb[..., 0] > 150, frame.rgb[..., 2] > 150
    left = np.arange(frame.rgb.shape[1]) < frame.rgb.shape[1] / 2
    return [("chair", red & left), ("chair", red & ~left), ("floor", blue), ("wall", ~red & ~blue)]


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


@pytest.mark.parametrize("size", [(128, 96), (97, 160)], ids=str)
@pytest.mark.parametrize("signature", SIGNATURES)
def test_each_piece_of_a_class_is_a_mask_whatever_the_signature(
    tmp_path: Path, signature: str, size: tuple[int, int]
) -> None:
    segmenter = make_segmenter("semantic", {"weights": write_semantic(tmp_path / "m.onnx", **SIGNATURES[signature])})
    frame = picture(*size)
    masks = segmenter.segment(frame)
    assert sorted(masks.class_names or ()) == ["chair", "chair", "floor", "wall"]
    assert masks.masks.shape[1:] == size[::-1]
    assert not (masks.masks.sum(axis=0) > 1).any()
    np.testing.assert_array_equal(masks.is_stuff, [name != "chair" for name in masks.class_names or ()])
    for name, expected in truth(frame):
        best = max(iou(m, expected) for m, n in zip(masks.masks, masks.class_names or (), strict=True) if n == name)
        assert best > (0.75 if SIGNATURES[signature].get("pool", 1) > 1 else 0.9)


NAMED = dict(enumerate(NAMES))
SPELLINGS = {
    "Python": {"names": str(NAMED)},
    "JSON": {"names": json.dumps(NAMED)},
    "list": {"classes": json.dumps(NAMES)},
    "tuple": {"CLASSES": str(NAMES)},
    "lines": {"labels": "\n".join(NAMES)},
    "commas": {"class_names": ", ".join(NAMES)},
    "reversed": {"label2id": "{}", "id2label": str({name: number for number, name in NAMED.items()})},
    "objects": {"categories": json.dumps([{"id": number, "name": name} for number, name in NAMED.items()])},
    "synonyms": {"names": str({0: "other", 1: "wall", 2: "floor;flooring", 3: "chair, seat"})},
}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_names_are_read_in_many_spellings(tmp_path: Path, spelling: str) -> None:
    segmenter = SemanticSegmenter(write_semantic(tmp_path / "m.onnx", metadata=SPELLINGS[spelling]))
    assert segmenter.class_names == NAMES


def test_names_come_from_a_file_or_from_the_configuration_beside_the_model(tmp_path: Path) -> None:
    (tmp_path / "onnx").mkdir()
    file = write_semantic(tmp_path / "onnx" / "model.onnx", metadata={})
    with pytest.raises(BadInput, match=r"does not say what its classes are called.* option names") as refused:
        SemanticSegmenter(file)
    assert "\n" not in str(refused.value)
    (tmp_path / "names.txt").write_text("nothing\nceiling\nground\nsofa\n")
    renamed = SemanticSegmenter(file, names=tmp_path / "names.txt").segment(picture())
    assert set(renamed.class_names or ()) == {"ceiling", "ground", "sofa"}
    (tmp_path / "config.json").write_text(json.dumps({"id2label": {str(n): name for n, name in NAMED.items()}}))
    assert SemanticSegmenter(tmp_path).class_names == NAMES  # as the hub lays out exports: onnx/model.onnx


@pytest.mark.parametrize("text", ["{0: 'wall'", "[1, 2]", "{'a': 'b'}", "{-1: 'wall'}", "7", "{0: __import__('os')}"])
def test_names_that_cannot_be_read_are_refused_in_one_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(BadInput, match=r"m\.onnx: its metadata 'names'") as refused:
        SemanticSegmenter(write_semantic(tmp_path / "m.onnx", metadata={"names": text}))
    assert "\n" not in str(refused.value)


def test_what_is_stuff_can_be_said(tmp_path: Path) -> None:
    file = write_semantic(tmp_path / "m.onnx")
    assert SemanticSegmenter(file, stuff="chair, wall").is_stuff.tolist() == [False, True, False, True]
    assert SemanticSegmenter(file, stuff=["floor"]).is_stuff.tolist() == [False, False, True, False]
    assert not SemanticSegmenter(file, stuff=[]).is_stuff.any()
    with pytest.raises(BadInput, match="stuff names 'flor', which the model does not know; the nearest: floor"):
        SemanticSegmenter(file, stuff="flor")


def test_classes_that_are_none_and_specks_are_left_out(tmp_path: Path) -> None:
    file = write_semantic(tmp_path / "m.onnx")
    assert set(SemanticSegmenter(file, ignore="Wall,chair").segment(picture()).class_names or ()) == {"floor"}
    frame = picture()
    frame.rgb[10:13, 10:13] = (200, 30, 60)  # 9 pixels, 225 at 640x480
    assert (SemanticSegmenter(file).segment(frame).class_names or ()).count("chair") == 3
    assert (SemanticSegmenter(file, min_pixels=250).segment(frame).class_names or ()).count("chair") == 2


def test_scores_are_mean_probabilities_or_what_is_said(tmp_path: Path) -> None:
    masks = SemanticSegmenter(write_semantic(tmp_path / "m.onnx")).segment(picture())
    chair = (np.array([200, 30, 60]) / 255 - [0.485, 0.456, 0.406]) / [0.229, 0.224, 0.225]
    logits = np.array([-9, 0.5, chair[2] - chair[0], chair[0] - chair[1]])
    probability = np.exp(logits.max()) / np.exp(logits).sum()
    assert masks.scores[(masks.class_names or ()).index("chair")] == pytest.approx(probability, abs=1e-4)
    unsure = SemanticSegmenter(tmp_path / "m.onnx", confidence=float(probability) - 0.01).segment(picture())
    assert set(unsure.class_names or ()) == {"chair", "floor"}
    told = SemanticSegmenter(write_semantic(tmp_path / "c.onnx", gives="classes"), score=0.7).segment(picture())
    np.testing.assert_allclose(told.scores, 0.7)


@pytest.mark.parametrize(
    ("metadata", "options", "mean", "std"),
    [
        ({}, {}, (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)),
        ({}, {"mean": 0.5, "std": [0.5, 0.25, 0.5]}, (0.5, 0.5, 0.5), (0.5, 0.25, 0.5)),
        ({}, {"mean": "0,0,0", "std": 1}, (0, 0, 0), (1, 1, 1)),
        ({"mean": "[127.5, 127.5, 127.5]", "std": "(127.5, 127.5, 127.5)"}, {}, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)),
        ({"mean": "0.5"}, {}, (0.5, 0.5, 0.5), (0.229, 0.224, 0.225)),
    ],
)
def test_floats_are_normalised_as_the_file_or_an_option_says(
    tmp_path: Path, metadata: dict, options: dict, mean: tuple, std: tuple
) -> None:
    file = write_semantic(tmp_path / "m.onnx", metadata={"names": str(NAMES), **metadata})
    network = SemanticSegmenter(file, **options).network
    assert isinstance(network, OnnxNetwork)
    expected = (picture().rgb / 255 - mean) / std
    np.testing.assert_allclose(network.input(picture().rgb)[0].transpose(1, 2, 0), expected, atol=1e-5)


def test_the_image_processor_beside_the_file_says_how_to_normalise(tmp_path: Path) -> None:
    file = write_semantic(tmp_path / "m.onnx")
    for settings, low in (({"image_mean": [0.5] * 3, "image_std": [0.5] * 3}, -1), ({"do_normalize": False}, 0)):
        (tmp_path / "preprocessor_config.json").write_text(json.dumps(settings))
        network = SemanticSegmenter(file).network
        assert isinstance(network, OnnxNetwork)
        assert network.input(np.zeros((96, 128, 3), np.uint8)).min() == low


@pytest.mark.parametrize(("size", "shape"), [(None, (480, 640)), (320, (256, 320))])
def test_open_inputs_keep_the_shape_of_the_image(tmp_path: Path, size: int | None, shape: tuple) -> None:
    network = SemanticSegmenter(write_semantic(tmp_path / "m.onnx", size=("h", "w")), size=size).network
    assert isinstance(network, OnnxNetwork)
    assert network.input(picture().rgb).shape == (1, 3, *shape)


@pytest.mark.parametrize(
    ("export", "options", "said"),
    [
        (
            {"metadata": {"names": "['wall', 'floor', 'chair']"}},
            {},
            "gives classes 1x4x96x128, expected a class map 1xHxW of numbers below 3, or logits 1x3xHxW or 1xHxWx3, "
            "for 3 class names",
        ),
        ({}, {"names": "missing.txt"}, r"missing\.txt cannot be read: No such file"),
        ({}, {"size": 320}, "size = 320: it is for models that leave it open"),
        ({"takes": "bytes"}, {"mean": 0.5}, "mean and std are for floating-point images"),
        ({}, {"mean": "grey"}, "mean is three numbers"),
        ({}, {"std": 0}, "std is three numbers above 0"),
        ({}, {"confidence": 2}, "confidence and score from 0 to 1"),
        ({}, {"min_pixels": 0}, "min_pixels >= 1"),
        ({}, {"ignore": 3}, "3 is no list of names"),
        ({}, {"weigth": 3}, "there is no 'weigth', its options are weights, "),
    ],
)
def test_what_cannot_be_used_is_refused_at_once(tmp_path: Path, export: dict, options: dict, said: str) -> None:
    file = write_semantic(tmp_path / "other.onnx", **export)
    with pytest.raises(BadInput, match=said) as refused:
        make_segmenter("semantic", {"weights": file, **options})
    assert "\n" not in str(refused.value)


def test_inputs_of_another_kind_are_refused_at_once(tmp_path: Path) -> None:
    from tests.support.yolo_exports import dense, write_export

    grey = write_export(tmp_path / "grey.onnx", dense(8400, []), input_shape=(1, 1, 640, 640))
    with pytest.raises(BadInput, match=r"grey\.onnx takes images 1x1x640x640 .*expected one colour image 1x3xHxW"):
        SemanticSegmenter(grey)
    yolo = write_export(tmp_path / "yolo.onnx", dense(8400, []))
    with pytest.raises(BadInput, match=r"yolo\.onnx gives output0 1x116x8400, output1 1x32x160x160, expected"):
        SemanticSegmenter(yolo)


@pytest.mark.parametrize(
    ("export", "said"),
    [
        ({"metadata": {"names": "['wall']"}, "size": ("h", "w")}, "an output 1x4x480x640, expected .*1x1xHxW"),
        ({"metadata": {"names": "['wall', 'floor']"}, "gives": "classes"}, "class 3, expected .*below 2"),
    ],
)
def test_open_shapes_that_turn_out_wrong_are_refused_at_the_first_frame(
    tmp_path: Path, export: dict, said: str
) -> None:
    segmenter = SemanticSegmenter(write_semantic(tmp_path / "other.onnx", **export))
    with pytest.raises(BadInput, match=rf"other\.onnx gives {said}"):
        segmenter.segment(picture())


def test_it_travels_to_another_process_used_or_not(tmp_path: Path) -> None:
    segmenter = SemanticSegmenter(write_semantic(tmp_path / "m.onnx"))
    fresh = pickle.loads(pickle.dumps(segmenter))
    masks = segmenter.segment(picture())
    used = pickle.loads(pickle.dumps(segmenter))
    for other in (fresh, used):
        np.testing.assert_array_equal(other.segment(picture()).masks, masks.masks)


@pytest.fixture(scope="module")
def mosaic(real_data: Path) -> SemanticSegmenter:
    file = real_data.parent / "models" / "mosaic-r3-ade31.onnx"
    if not file.is_file():
        pytest.skip(f"no {file}: the real semantic model is not here")
    return SemanticSegmenter(file)


def test_a_real_kitchen_has_floor_wall_cabinet_table_and_chairs(real_data: Path, mosaic: SemanticSegmenter) -> None:
    masks = mosaic.segment(open_sequence(real_data / "redkitchen")[0])
    names = masks.class_names or ()
    at = {
        (row, column): [n for n, m in zip(names, masks.masks, strict=True) if m[row, column]]
        for row, column in ((380, 100), (90, 60), (320, 420), (160, 230))
    }
    assert list(at.values()) == [["floor"], ["cabinet"], ["table"], ["chair"]]
    assert {"wall", "floor"} <= {n for n, stuff in zip(names, masks.is_stuff, strict=True) if stuff}
    assert not masks.is_stuff[[names.index("cabinet"), names.index("table"), names.index("chair")]].any()
