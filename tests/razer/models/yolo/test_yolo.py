"""The yolo segmenter on ONNX files with the signature of each export, on files that are none, and on real frames."""

from __future__ import annotations

import pickle
from pathlib import Path

import cv2
import numpy as np
import onnxruntime
import pytest
import torch

from app.cli import main
from data_tools import open_sequence
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.models import make_segmenter
from razer.models.yolo.segmenter import YoloSegmenter
from tests.support.recordings import write_seven_scenes
from tests.support.yolo_exports import dense, end_to_end, write_export

RED = (slice(101, 223), slice(50, 333))  # rows and columns of the red patch in a picture of 640x480
WHOLE = (0, 0, 4000, 4000, 0.75, 56)  # all of the input, a chair


def picture(width: int = 640, height: int = 480) -> Frame:
    """A grey picture with a red patch at the same share of its sides, whatever its size."""
    rgb = np.full((480, 640, 3), 120, np.uint8)
    rgb[RED] = (200, 30, 60)
    rgb = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_NEAREST)
    return Frame(0, 0.0, rgb, np.ones((height, width), np.float32), Intrinsics(width, height, 500, 500, 320, 240))


def red(frame: Frame) -> np.ndarray:
    return frame.rgb[..., 0] > 150


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


OPEN_INPUT = ("batch", 3, "height", "width")
OPEN = {"input_shape": OPEN_INPUT, "output_shapes": (("batch", 116, "anchors"), ("batch", 32, "h", "w"))}
OPEN_END = {"input_shape": OPEN_INPUT, "output_shapes": (("batch", 300, "anchors"), ("batch", 32, "h", "w"))}
ALL_OPEN = {"input_shape": ("b", "c", "h", "w"), "output_shapes": (("b", "n", "a"), ("b", "m", "gh", "gw"))}
FASTSAM = {"input_shape": (1, 3, 1024, 1024), "metadata": {"task": "segment", "names": "{0: 'object'}"}}
EXPORTS = {
    "v8": (dense(8400, [WHOLE]), {}),
    "end to end": (end_to_end(300, [WHOLE]), {}),
    "FastSAM": (dense(21504, [(*WHOLE[:5], 0)], 1), FASTSAM),
    "many classes": (dense(2100, [(*WHOLE[:5], 4000)], 4585), {"metadata": {"names": str(["chair"] * 4585)}}),
    "open": (dense(6300, [WHOLE]), OPEN),
    "open, end to end": (end_to_end(300, [WHOLE]), OPEN_END),
    "all open": (dense(6300, [WHOLE]), ALL_OPEN),
    "float16": (dense(8400, [WHOLE]), {"half": True}),
    "not square": (dense(6300, [WHOLE]), {"input_shape": (1, 3, 480, 640)}),
    "small": (dense(2100, [WHOLE]), {"input_shape": (1, 3, 320, 320)}),
    "other prototypes": (dense(8400, [WHOLE], n_prototypes=24), {"n_prototypes": 24}),
}


@pytest.mark.parametrize("size", [(640, 480), (480, 640), (1296, 968), (333, 257)], ids=str)
@pytest.mark.parametrize("export", EXPORTS)
def test_what_is_red_is_found_whatever_the_export(tmp_path: Path, export: str, size: tuple[int, int]) -> None:
    predictions, options = EXPORTS[export]
    segmenter = make_segmenter("yolo", {"weights": str(write_export(tmp_path / "m.onnx", predictions, **options))})
    frame = picture(*size)
    masks = segmenter.segment(frame)
    assert masks.class_names == (("object",) if export == "FastSAM" else ("chair",))
    assert masks.masks.shape == (1, size[1], size[0])
    np.testing.assert_allclose(masks.scores, [0.75], atol=1e-3)
    # A cell of a small input is several pixels wide, and its border as uncertain.
    assert iou(masks.masks[0], red(frame)) > (0.93 if export == "small" or min(size) < 300 else 0.97)


@pytest.mark.parametrize(
    ("options", "metadata", "shape"),
    [
        ({}, {}, (1, 3, 480, 640)),
        ({"size": 320}, {}, (1, 3, 256, 320)),
        ({"size": 650}, {"stride": "64"}, (1, 3, 576, 704)),
        ({}, {"imgsz": "[1280, 1280]"}, (1, 3, 960, 1280)),
        ({}, {"imgsz": "320"}, (1, 3, 256, 320)),
    ],
)
def test_open_inputs_are_no_larger_than_needed(tmp_path: Path, options: dict, metadata: dict, shape: tuple) -> None:
    file = write_export(tmp_path / "m.onnx", dense(6300, [WHOLE]), **OPEN, metadata=metadata)
    segmenter = YoloSegmenter(file, **options)
    assert segmenter.export.letterbox((480, 640)).batch(picture().rgb).shape == shape
    assert iou(segmenter.segment(picture()).masks[0], red(picture())) > 0.93


def test_the_network_sees_a_letterbox_of_rgb_from_0_to_1(tmp_path: Path) -> None:
    segmenter = YoloSegmenter(write_export(tmp_path / "m.onnx", dense(8400, [])))
    batch = segmenter.export.letterbox((480, 640)).batch(picture().rgb)
    assert (batch.shape, batch.dtype) == ((1, 3, 640, 640), np.float32)
    expected = np.full((640, 640, 3), 114 / 255)
    expected[80:560] = picture().rgb / 255
    np.testing.assert_allclose(batch[0].transpose(1, 2, 0), expected, atol=1e-6)


def test_settings_are_obeyed(tmp_path: Path) -> None:
    detections = [(*WHOLE[:4], score, number) for score, number in ((0.9, 56), (0.8, 41), (0.3, 7), (0.1, 8))]
    file = write_export(tmp_path / "m.onnx", dense(8400, detections))
    assert YoloSegmenter(file).segment(picture()).class_names == ("chair", "cup", "class 7")
    assert YoloSegmenter(file, confidence=0.5).segment(picture()).class_names == ("chair", "cup")
    assert YoloSegmenter(file, max_masks=1).segment(picture()).class_names == ("chair",)
    assert YoloSegmenter(file, confidence=0.95).segment(picture()).masks.shape == (0, 480, 640)


def test_a_model_without_names_gives_none(tmp_path: Path) -> None:
    masks = YoloSegmenter(write_export(tmp_path / "m.onnx", dense(8400, [WHOLE]), metadata={})).segment(picture())
    assert (len(masks), masks.class_names) == (1, None)


def test_it_travels_to_another_process_used_or_not(tmp_path: Path) -> None:
    segmenter = YoloSegmenter(write_export(tmp_path / "m.onnx", dense(8400, [WHOLE])))
    fresh = pickle.loads(pickle.dumps(segmenter))
    masks = segmenter.segment(picture())
    used = pickle.loads(pickle.dumps(segmenter))
    for other in (fresh, used):
        np.testing.assert_array_equal(other.segment(picture()).masks, masks.masks)


@pytest.mark.parametrize(
    ("predictions", "options", "said"),
    [
        (dense(8400, []), {"drop_prototypes": True}, "no YOLO segmentation model"),
        (dense(8400, [], 79), {}, r"115x8400 .* 4 \+ 80 classes \+ 32 rows"),
        (dense(8400, [], n_prototypes=24), {}, "108x8400"),
        (end_to_end(300, [], 31), {}, "300x37"),
        (dense(8400, [])[:, :, None], {}, "output0 1x116x1x8400, output1 1x32x160x160"),
        (dense(8400, []), {"metadata": {"task": "detect"}}, "to detect"),
        (dense(8400, []), {"metadata": {"names": "{0: 'chair'"}}, "'names' cannot be read"),
        (dense(8400, []), {"metadata": {"names": "{1: 'chair'}"}}, "number the classes from 0"),
        (dense(8400, []), {"metadata": {"names": "{0: 'chair', 'x': 'cup'}"}}, "number the classes from 0"),
        (dense(8400, []), {"metadata": {"imgsz": "large"}, "input_shape": (1, 3, "h", "w")}, "'imgsz' cannot be read"),
        (dense(8400, []), {"metadata": {"stride": "0"}}, "'stride' is 0"),
        (dense(8400, []), {"input_shape": (1, 1, 640, 640)}, "1x1x640x640"),
        (dense(8400, []), {"input_shape": (4, 3, 640, 640)}, "4x3x640x640"),
    ],
)
def test_a_model_of_another_kind_is_refused_at_once(
    tmp_path: Path, predictions: np.ndarray, options: dict, said: str
) -> None:
    file = write_export(tmp_path / "other.onnx", predictions, **options)
    with pytest.raises(BadInput, match=said) as refused:
        YoloSegmenter(file)
    assert "other.onnx" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_open_shapes_that_turn_out_wrong_are_refused_at_the_first_frame(tmp_path: Path) -> None:
    segmenter = YoloSegmenter(write_export(tmp_path / "other.onnx", dense(6300, [], 79), **ALL_OPEN))
    with pytest.raises(BadInput, match=r"other\.onnx: predictions of 115x6300"):
        segmenter.segment(picture())
    beyond = write_export(tmp_path / "beyond.onnx", end_to_end(300, [(*WHOLE[:5], 80)]))
    with pytest.raises(BadInput, match=r"beyond\.onnx: predicts class 80, but names 80"):
        YoloSegmenter(beyond).segment(picture())


def test_a_graph_that_fails_on_the_input_it_promised_to_take_is_refused(tmp_path: Path) -> None:
    # The grid of the prototypes is promised to be of one size, which proves wrong when the graph runs.
    segmenter = YoloSegmenter(write_export(tmp_path / "m.onnx", dense(8400, [WHOLE])))
    with pytest.raises(BadInput, match=r"m\.onnx cannot compute images 1x3x32x32"):
        segmenter.model(np.zeros((1, 3, 32, 32), np.float32))


@pytest.mark.parametrize("content", [b"", b"not a model", None], ids=["empty", "text", "cut short"])
def test_a_damaged_file_is_refused_at_once(tmp_path: Path, content: bytes | None) -> None:
    whole = write_export(tmp_path / "whole.onnx", dense(8400, [WHOLE])).read_bytes()
    (tmp_path / "broken.onnx").write_bytes(whole[: len(whole) // 2] if content is None else content)
    with pytest.raises(BadInput, match=r"broken\.onnx is no ONNX model, or is damaged") as refused:
        YoloSegmenter(tmp_path / "broken.onnx")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"confidence": 0}, "confidence"),
        ({"iou": 1.5}, "iou"),
        ({"max_masks": 0}, "max_masks"),
        ({"size": 320}, "size = 320"),
        ({"device": "tpu"}, "not 'tpu'"),
        ({"weights": "nowhere.onnx"}, r"nowhere\.onnx"),
        ({"weights": "."}, "option weights"),
        ({"colour": 1}, "colour"),
    ],
)
def test_impossible_options_are_refused_at_once(tmp_path: Path, options: dict, said: str) -> None:
    file = write_export(tmp_path / "m.onnx", dense(8400, [WHOLE]))
    with pytest.raises(BadInput, match=said):
        make_segmenter("yolo", {"weights": file} | options)


def test_cuda_is_refused_where_there_is_none_and_taken_where_there_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write_export(tmp_path / "m.onnx", dense(8400, [WHOLE]))
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: ["CPUExecutionProvider"])
    with pytest.raises(BadInput, match="pip install onnxruntime-gpu"):
        YoloSegmenter(file, device="cuda")
    monkeypatch.setattr(
        onnxruntime, "get_available_providers", lambda: ["CUDAExecutionProvider", "CPUExecutionProvider"]
    )
    assert YoloSegmenter(file).model.providers[0] == "CUDAExecutionProvider"
    assert YoloSegmenter(file, device="cpu").model.providers == ["CPUExecutionProvider"]


@pytest.mark.parametrize("found_out", ["at once", "at the first frame"])
def test_a_run_with_an_unusable_model_ends_with_one_line_and_no_folder(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], found_out: str
) -> None:
    weights = write_export(tmp_path / "other.onnx", dense(6300, [], 79), **ALL_OPEN)
    if found_out == "at once":
        weights.write_bytes(b"not a model")
    recording = write_seven_scenes(tmp_path / "recording")
    arguments = ["run", str(recording), "-o", str(tmp_path / "out"), "--segmenter", "yolo"]
    with pytest.raises(SystemExit) as stopped:
        main([*arguments, "--set", f"segmenter.options.weights={weights}"])
    last = capfd.readouterr().err.strip().splitlines()[-1]
    assert stopped.value.code == 2
    assert last.startswith("razer: ")
    assert "other.onnx" in last
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.onnx", "recording"]


@pytest.fixture(scope="module")
def detector(real_data: Path) -> YoloSegmenter:
    file = real_data.parent / "models" / "yolov8n-seg.onnx"
    if not file.is_file():
        pytest.skip(f"no {file}: the real detector is not here")
    return YoloSegmenter(file)


def test_a_real_kitchen_has_chairs_a_table_cups_a_tv_and_books(real_data: Path, detector: YoloSegmenter) -> None:
    frames = open_sequence(real_data / "redkitchen")
    first, later = (detector.segment(frames[index]) for index in (0, 300))
    assert {"chair", "dining table", "cup"} <= set(first.class_names or ())
    assert {"chair", "dining table", "cup", "tv", "book"} <= set(later.class_names or ())
    table = first.masks[(first.class_names or ()).index("dining table")]
    assert table[300, 420]  # on the table's top, between its papers
    assert not table[200, 60]  # the red cupboard


def test_real_masks_agree_with_torch(real_data: Path, detector: YoloSegmenter) -> None:
    frame = open_sequence(real_data / "redkitchen")[300]
    letterbox = detector.export.letterbox((480, 640))
    predictions, prototypes = detector.model(letterbox.batch(frame.rgb))
    rows = predictions[0].T
    masks = detector.segment(frame)
    assert len(masks) >= 5
    for name, score, mask in zip(masks.class_names or (), masks.scores, masks.masks, strict=True):
        number = (detector.export.class_names or ()).index(name)
        row = rows[np.flatnonzero(rows[:, 4 + number] == score)[0]]
        sums = torch.tensor(row[84:]) @ torch.tensor(prototypes[0]).flatten(1)
        grown = torch.nn.functional.interpolate(sums.view(1, 1, 160, 160), (640, 640), mode="bilinear")[0, 0] > 0
        (cx, cy, w, h), (v, u) = row[:4], np.mgrid[:640, :640] + 0.5
        inside = (np.abs(u - cx) < w / 2) & (np.abs(v - cy) < h / 2)
        assert iou(mask, (grown.numpy() & inside)[80:560]) > 0.99
