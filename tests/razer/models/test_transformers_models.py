"""Segmenters of the transformers library on tiny checkpoints with random weights, beside the library's own way."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import torch

from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.models import make_segmenter
from razer.models.mask_boxes import mask_boxes
from razer.models.panoptic_masks import panoptic_masks
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.sam.mask_proposals import masks_in_boxes
from razer.models.sam.segmenter import SamSegmenter
from razer.models.sam.torch_sam import TorchSam
from razer.models.text_prompted.box_detector import PhraseDetector, phrase_spans
from razer.models.text_prompted.prompts import prompt_phrases
from razer.models.text_prompted.sam3 import Sam3Detector
from razer.models.text_prompted.segmenter import PromptedSegmenter
from tests.support.sam_exports import EXPORTS

transformers = pytest.importorskip("transformers", reason="the extra 'transformers' is not installed")
from tests.support import tiny_checkpoints as tiny  # noqa: E402

ANYTHING = {"min_quality": 0.0, "min_stability": 0.0}


def frame_of(width: int, height: int) -> Frame:
    rgb = np.random.default_rng(width).integers(0, 256, (height, width, 3)).astype(np.uint8)
    camera = Intrinsics(width, height, 100.0, 100.0, width / 2, height / 2)
    return Frame(0, 0.0, rgb, np.ones((height, width), np.float32), camera)


def answers(model: TorchSam, rgb: np.ndarray, prompts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    features, view = model.encode(rgb)
    ask = model.in_boxes if prompts.shape[1] == 4 else model.at_points
    masks, scores = zip(*ask(features, view, prompts), strict=True)
    return np.concatenate(masks), np.concatenate(scores)


POINTS = np.array([[3.0, 5.0], [40.0, 20.0], [60.0, 44.0]])
BOXES = np.array([[3.0, 5.0, 30.0, 40.0], [20.0, 10.0, 64.0, 48.0]])


@pytest.mark.parametrize("prompts", [POINTS, BOXES], ids=["points", "boxes"])
def test_sam_answers_as_the_library_does(tmp_path: Path, prompts: np.ndarray) -> None:
    theirs = tiny.sam(tmp_path)
    rgb = frame_of(64, 48).rgb  # as long as the model's side: nothing is resized, and a part of the square is empty
    name = "input_boxes" if prompts.shape[1] == 4 else "input_points"
    given = [prompts.tolist()] if name == "input_boxes" else [[[point] for point in prompts.tolist()]]
    processor = transformers.SamProcessor(transformers.SamImageProcessor.from_pretrained(tmp_path))
    inputs = processor(rgb, return_tensors="pt", **{name: given})
    inputs = {key: value.float() if value.is_floating_point() else value for key, value in inputs.items()}
    with torch.no_grad():
        expected = theirs(**{key: inputs[key] for key in ("pixel_values", name)})
    masks, scores = answers(TorchSam(Checkpoint.of(tmp_path), 2, "cpu"), rgb, prompts)
    np.testing.assert_allclose(scores, expected.iou_scores[0].numpy(), atol=1e-4)
    np.testing.assert_allclose(masks, expected.pred_masks[0, :, :, :24].numpy(), atol=1e-3)
    assert masks.shape[2:] == (24, 32)


@pytest.mark.parametrize("prompts", [POINTS, BOXES], ids=["points", "boxes"])
def test_sam2_answers_as_the_library_does(tmp_path: Path, prompts: np.ndarray) -> None:
    theirs = tiny.sam2(tmp_path)
    rgb = frame_of(64, 64).rgb
    pixels = torch.from_numpy(((rgb / 255 - 0.5) / 0.25).transpose(2, 0, 1)[None]).float()
    points = torch.from_numpy(prompts).float()[None]
    given = {"input_boxes": points} if prompts.shape[1] == 4 else {"input_points": points[:, :, None]}
    with torch.no_grad():
        expected = theirs(pixel_values=pixels, **given)
    masks, scores = answers(TorchSam(Checkpoint.of(tmp_path), 2, "cpu"), rgb, prompts)
    np.testing.assert_allclose(scores, expected.iou_scores[0].numpy(), atol=1e-4)
    np.testing.assert_allclose(masks, expected.pred_masks[0].numpy(), atol=1e-3)


@pytest.mark.parametrize("kind", ["sam", "sam2"])
def test_a_checkpoint_serves_the_sam_segmenter(tmp_path: Path, kind: str) -> None:
    getattr(tiny, kind)(tmp_path)
    segmenter = make_segmenter("sam", {"weights": str(tmp_path), "points": 3, "batch": 4, "device": "cpu", **ANYTHING})
    frame = frame_of(90, 60)
    masks = segmenter.segment(frame)
    assert masks.masks.shape[1:] == (60, 90)
    unpickled = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    np.testing.assert_array_equal(unpickled.masks, masks.masks)


def literal_panoptic(
    class_logits: torch.Tensor, mask_logits: torch.Tensor, size: tuple[int, int], confidence: float
) -> list[tuple[float, int, np.ndarray]]:
    """Pixel by pixel: the query with the largest product of class score and mask probability owns it."""
    inside = torch.nn.functional.interpolate(mask_logits[None], size, mode="bilinear")[0].sigmoid().numpy()
    queries = []
    for row, mask in zip(class_logits.softmax(-1).numpy(), inside, strict=True):
        if row.argmax() < len(row) - 1 and row.max() > confidence:
            queries.append((float(row.max()), int(row.argmax()), mask))
    won = [np.zeros(size, bool) for _ in queries]
    for y in range(size[0]):
        for x in range(size[1]):
            best = max(range(len(queries)), key=lambda q: queries[q][0] * queries[q][2][y, x])
            won[best][y, x] = queries[best][2][y, x] >= 0.5
    kept = zip(queries, won, strict=True)
    return [(s, c, mine) for (s, c, mask), mine in kept if mine.any() and mine.sum() >= 0.8 * (mask >= 0.5).sum()]


def test_pixels_go_to_the_query_that_is_surest() -> None:
    torch.manual_seed(0)
    class_logits = 3 * torch.randn(8, 4)
    mask_logits = torch.full((8, 10, 12), -6.0)
    for query in range(8):
        y, x = divmod(query, 3)
        mask_logits[query, 3 * y : 3 * y + 4, 4 * x : 4 * x + 5] = 3 * torch.rand(1) + 0.2
    masks, scores, classes = panoptic_masks(class_logits, mask_logits, (20, 30), 0.4)
    expected = literal_panoptic(class_logits, mask_logits, (20, 30), 0.4)
    assert 2 <= len(expected) < 8
    np.testing.assert_allclose(scores.numpy(), [score for score, _, _ in expected], rtol=1e-5)
    assert classes.tolist() == [number for _, number, _ in expected]
    np.testing.assert_array_equal(masks.numpy(), [mask for _, _, mask in expected])


@pytest.mark.parametrize("kind", ["mask2former", "oneformer"])
def test_panoptic_segmenters_look_at_an_image_as_the_library_does(tmp_path: Path, kind: str) -> None:
    theirs = getattr(tiny, kind)(tmp_path)
    frame = frame_of(90, 60)
    segmenter = make_segmenter("panoptic", {"weights": tmp_path, "confidence": 0.0, "device": "cpu"})
    masks = segmenter.segment(frame)
    pixels = transformers.Mask2FormerImageProcessor(size={"height": 64, "width": 64})(frame.rgb, return_tensors="pt")
    text = tiny.clip_tokenizer()("the task is panoptic", padding="max_length", max_length=20, truncation=True)
    tokens = torch.tensor([text["input_ids"]]) * torch.tensor([text["attention_mask"]])
    with torch.no_grad():
        outputs = theirs(**pixels, **({"task_inputs": tokens} if kind == "oneformer" else {}))
    expected = literal_panoptic(outputs.class_queries_logits[0], outputs.masks_queries_logits[0], (60, 90), 0.0)
    np.testing.assert_allclose(masks.scores, [score for score, _, _ in expected], atol=1e-4)
    assert masks.class_names == tuple(tiny.LABELS[number] for _, number, _ in expected)
    assert masks.is_stuff.tolist() == [name == "wall" for name in masks.class_names]
    assert (masks.masks == np.stack([mask for _, _, mask in expected])).mean() > 0.999
    unpickled = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    np.testing.assert_array_equal(unpickled.masks, masks.masks)


def test_semantic_checkpoints_look_at_an_image_as_the_library_does(tmp_path: Path) -> None:
    theirs = tiny.segformer(tmp_path)
    frame = frame_of(90, 60)
    segmenter = make_segmenter("semantic", {"weights": tmp_path, "min_pixels": 1, "device": "cpu"})
    processor = transformers.SegformerImageProcessor.from_pretrained(tmp_path)
    with torch.no_grad():
        outputs = theirs(**processor(frame.rgb, return_tensors="pt"))
    (expected,) = processor.post_process_semantic_segmentation(outputs, target_sizes=[(60, 90)])
    masks = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    labels = {name: number for number, name in tiny.LABELS.items()}
    classes = np.full((60, 90), -1)
    for name, mask in zip(masks.class_names or (), masks.masks, strict=True):
        classes[mask] = labels[name]
    assert len(set(masks.class_names or ())) >= 2
    assert (classes == expected.numpy()).mean() > 0.99
    np.testing.assert_array_equal(masks.is_stuff, [name == "wall" for name in masks.class_names or ()])
    with pytest.raises(BadInput, match="options mean, std and size are for ONNX files"):
        make_segmenter("semantic", {"weights": tmp_path, "size": 64})


def test_panoptic_with_nothing_sure_is_no_mask(tmp_path: Path) -> None:
    tiny.mask2former(tmp_path)
    masks = make_segmenter("panoptic", {"weights": tmp_path, "confidence": 1.0}).segment(frame_of(90, 60))
    assert masks.masks.shape == (0, 60, 90)


def test_words_of_grounding_dino_take_the_score_of_their_best_token(tmp_path: Path) -> None:
    theirs = tiny.grounding_dino(tmp_path)
    rgb, words = frame_of(96, 64).rgb, ("cup.", "Red chair", "table")  # the stop is not the word's
    detections = PhraseDetector(Checkpoint.of(tmp_path), words, 0.0, "cpu").detect(rgb)
    processor = transformers.GroundingDinoProcessor.from_pretrained(tmp_path)
    inputs = processor(images=rgb, text="cup. red chair. table.", return_tensors="pt")
    with torch.no_grad():
        outputs = theirs(**inputs)
    boxes = processor.post_process_grounded_object_detection(
        outputs, inputs.input_ids, threshold=0.0, target_sizes=[rgb.shape[:2]]
    )[0]["boxes"]
    np.testing.assert_allclose(detections.boxes, boxes.numpy().clip(0, [96, 64, 96, 64]), atol=1e-2)
    tokens = outputs.logits[0].sigmoid().numpy()  # [CLS] cup . red chair . table . [SEP]
    by_word = np.stack([tokens[:, 1], tokens[:, 3:5].max(axis=1), tokens[:, 6]], axis=1)
    np.testing.assert_allclose(detections.scores, by_word.max(axis=1), atol=1e-4)
    np.testing.assert_array_equal(detections.phrases, by_word.argmax(axis=1))


def test_more_words_than_a_sentence_holds_are_asked_in_parts(tmp_path: Path) -> None:
    tiny.grounding_dino(tmp_path)
    rgb, words = frame_of(96, 64).rgb, ("cup", "red chair", "table", "cups", "red table", "red red cup")
    whole = PhraseDetector(Checkpoint.of(tmp_path), words, 0.0, "cpu")
    detections = whole.detect(rgb)
    assert whole._batches == [[0, 1, 2, 3], [4, 5]]
    alone = PhraseDetector(Checkpoint.of(tmp_path), words[4:], 0.0, "cpu").detect(rgb)
    np.testing.assert_allclose(detections.boxes[9:], alone.boxes, atol=1e-4)
    np.testing.assert_array_equal(detections.phrases[9:], alone.phrases + 4)


def test_spans_leave_out_stops_and_ends() -> None:
    tokens = ["[CLS]", "cup", ".", "red", "chair", ".", "[SEP]"]
    assert list(phrase_spans(tokens)) == [slice(1, 2), slice(3, 5)]


def test_words_of_owlv2_are_the_librarys(tmp_path: Path) -> None:
    theirs = tiny.owlv2(tmp_path)
    rgb, words = frame_of(40, 32).rgb, ("cup", "chair", "door")
    detections = PhraseDetector(Checkpoint.of(tmp_path), words, 0.0, "cpu").detect(rgb)
    processor = transformers.Owlv2Processor.from_pretrained(tmp_path)
    inputs = processor(images=rgb, text=[list(words)], padding="max_length", max_length=16, return_tensors="pt")
    with torch.no_grad():
        outputs = theirs(**inputs)
    boxes = processor.post_process_grounded_object_detection(outputs, threshold=0.0, target_sizes=[(32, 40)])[0][
        "boxes"
    ]
    clipped = boxes.numpy().clip(0, [40, 32, 40, 32])
    inside = (clipped[:, 2:] > clipped[:, :2]).all(axis=1)
    scores = outputs.logits[0].sigmoid().max(-1)
    assert 0 < inside.sum() < len(inside)  # boxes beside the image are left out
    np.testing.assert_allclose(detections.boxes, clipped[inside], atol=1e-3)
    np.testing.assert_allclose(detections.scores, scores.values.numpy()[inside], atol=1e-4)
    np.testing.assert_array_equal(detections.phrases, scores.indices.numpy()[inside])


def test_boxes_become_masks_with_words_as_names(tmp_path: Path) -> None:
    tiny.owlv2(tmp_path / "detector")
    EXPORTS["edge-sam"].write(tmp_path / "sam")
    frame = frame_of(64, 48)
    segmenter = make_segmenter(
        "prompted",
        {"weights": tmp_path / "detector", "words": "cup, chair", "mask_weights": tmp_path / "sam", "confidence": 0.0,
         "most_iou": 1.0, "device": "cpu"},
    )  # fmt: skip
    masks = segmenter.segment(frame)
    assert set(masks.class_names or ()) <= {"cup", "chair"}
    assert (np.diff(masks.scores) <= 0).all()
    detections = segmenter.detector.detect(frame.rgb)
    assert len(masks) == len(detections.scores)
    expected = masks_in_boxes(segmenter.sam, frame.rgb, detections.boxes)[np.argsort(-detections.scores, kind="stable")]
    np.testing.assert_array_equal(masks.masks, expected)
    boxes = mask_boxes(masks.masks)
    has_pixels = masks.masks.any(axis=(1, 2))
    assert np.abs(boxes - detections.boxes[np.argsort(-detections.scores, kind="stable")])[has_pixels].max() < 2
    unpickled = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    np.testing.assert_array_equal(unpickled.masks, masks.masks)


def test_nothing_found_is_no_mask(tmp_path: Path) -> None:
    tiny.owlv2(tmp_path / "detector")
    EXPORTS["edge-sam"].write(tmp_path / "sam")
    options = {"words": ["cup"], "mask_weights": tmp_path / "sam", "confidence": 1.0}
    assert len(PromptedSegmenter(tmp_path / "detector", **options).segment(frame_of(64, 48))) == 0


def test_sam3_masks_are_the_librarys_for_each_word(tmp_path: Path) -> None:
    theirs = tiny.sam3(tmp_path)
    rgb, words = frame_of(56, 56).rgb, ("cup", "chair")
    masks, scores, numbers = Sam3Detector(Checkpoint.of(tmp_path), words, 0.0, "cpu").detect(rgb)
    pixels = torch.from_numpy(((rgb / 255 - 0.5) / 0.5).transpose(2, 0, 1))
    tokenizer = tiny.clip_tokenizer()
    for number, word in enumerate(words):
        text = tokenizer(word, padding="max_length", max_length=32, return_tensors="pt")
        with torch.no_grad():
            outputs = theirs(pixel_values=pixels[None].float(), **text)
        expected = outputs.pred_logits[0].sigmoid() * outputs.presence_logits[0].sigmoid()
        np.testing.assert_allclose(scores[numbers == number], expected.numpy(), atol=1e-4)
        upsampled = torch.nn.functional.interpolate(outputs.pred_masks, (56, 56), mode="bilinear")[0] > 0
        assert (masks[numbers == number] == upsampled.numpy()).mean() > 0.99
    segmenter = make_segmenter("prompted", {"weights": tmp_path, "words": words, "confidence": 0.0, "most_iou": 0.5})
    masks = segmenter.segment(frame_of(56, 56))
    assert 1 <= len(masks) <= len(scores)
    assert masks.scores[0] == pytest.approx(scores.max(), abs=1e-4)


def test_words_come_from_lists_texts_and_vocabularies() -> None:
    assert prompt_phrases([" cup", "red chair", "cup"]) == ("cup", "red chair")
    assert prompt_phrases("cup, red chair") == ("cup", "red chair")
    assert "chair" in prompt_phrases("scannet20")
    with pytest.raises(BadInput, match="no vocabulary"):
        prompt_phrases("cup")
    with pytest.raises(BadInput, match="words is empty"):
        prompt_phrases([])


def test_what_is_no_such_checkpoint_is_refused_at_once(tmp_path: Path) -> None:
    tiny.sam2(tmp_path / "sam2")
    tiny.owlv2(tmp_path / "owl")
    (tmp_path / "empty").mkdir()
    for name, options, message in [
        ("panoptic", {"weights": tmp_path / "sam2"}, "holds 'sam2', and panoptic takes"),
        ("panoptic", {"weights": tmp_path / "sam2", "confidence": 2}, "confidence is from 0 to 1"),
        ("prompted", {"weights": tmp_path / "sam2", "words": "cup,"}, "holds 'sam2': prompted takes"),
        ("prompted", {"weights": tmp_path / "owl", "words": "cup,"}, "mask_weights"),
        ("prompted", {"weights": tmp_path / "owl"}, "does not take these options"),
        ("sam", {"weights": tmp_path / "owl"}, "no model of SAM's family"),
        ("panoptic", {"weights": tmp_path / "empty"}, "is no checkpoint"),
        ("panoptic", {"weights": "oneformer-coco"}, "not downloaded: run 'razer models pull oneformer-coco'"),
        ("sam", {"weights": tmp_path / "sam2", "device": "tpu"}, "device is auto, cpu or cuda"),
    ]:
        with pytest.raises(BadInput, match=message):
            make_segmenter(name, options)


def test_a_truncated_file_and_one_without_weights_are_refused_at_once(tmp_path: Path) -> None:
    tiny.mask2former(tmp_path)
    file = tmp_path / "model.safetensors"
    file.write_bytes(file.read_bytes()[:-1000])
    with pytest.raises(BadInput, match=r"model\.safetensors is damaged or cut short"):
        make_segmenter("panoptic", {"weights": tmp_path})
    file.unlink()
    with pytest.raises(BadInput, match="has no weights"):
        make_segmenter("panoptic", {"weights": tmp_path})


def test_weights_of_another_model_under_this_name_are_told_on_loading(tmp_path: Path) -> None:
    tiny.mask2former(tmp_path / "one")
    tiny.owlv2(tmp_path / "other")
    (tmp_path / "one" / "model.safetensors").write_bytes((tmp_path / "other" / "model.safetensors").read_bytes())
    with pytest.raises(BadInput, match="another kind of model"):
        make_segmenter("panoptic", {"weights": tmp_path / "one"}).segment(frame_of(64, 64))


def test_without_the_library_the_command_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tiny.sam2(tmp_path)
    monkeypatch.setattr("razer.models.runtime.checkpoint.find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"pip install 'razer\[transformers\]'"):
        SamSegmenter(tmp_path)


def test_colours_come_from_either_file_of_settings(tmp_path: Path) -> None:
    tiny.sam2(tmp_path)
    assert Checkpoint.of(tmp_path).colours() == ((0.5,) * 3, (0.25,) * 3)
    (tmp_path / "preprocessor_config.json").write_text(json.dumps({"image_mean": [0.1, 0.2, 0.3]}))
    assert Checkpoint.of(tmp_path).colours()[0] == (0.1, 0.2, 0.3)
    assert Checkpoint(tmp_path / "none", {"model_type": "sam3_video"}).colours() == ((0.5,) * 3, (0.5,) * 3)
    (tmp_path / "preprocessor_config.json").write_text("{")
    with pytest.raises(BadInput, match="cannot be read"):
        Checkpoint.of(tmp_path).colours()
