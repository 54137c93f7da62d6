"""The sam segmenter on exports whose right answers are known, and files that are none."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import onnx
import pytest

from razer.errors import BadInput
from razer.frame import Frame, Intrinsics, Masks
from razer.models import make_segmenter
from razer.models.mask_boxes import mask_boxes
from razer.models.mask_filters import best_of_overlapping, mask_iou, stability
from razer.models.sam.export_files import encoder_and_decoder
from razer.models.sam.mask_proposals import point_grid
from razer.models.sam.segmenter import SamSegmenter
from razer.models.square_layout import SquareLayout
from tests.support.sam_exports import EXPORTS

GREYS = (10, 90, 170, 250)
rng = np.random.default_rng(5)


def frame_of(width: int, height: int) -> tuple[Frame, np.ndarray]:
    """Four parts of unlike brightness; and which of them each pixel is of."""
    part = np.zeros((height, width), int)
    part[: height // 2, width // 3 :] = 1
    part[height // 2 :, : width // 3] = 2
    part[height // 2 :, width // 3 :] = 3
    rgb = np.repeat(np.array(GREYS, np.uint8)[part][..., None], 3, axis=2)
    camera = Intrinsics(width, height, 100.0, 100.0, width / 2, height / 2)
    return Frame(0, 0.0, rgb, np.ones((height, width), np.float32), camera), part


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


@pytest.mark.parametrize("export", EXPORTS)
@pytest.mark.parametrize("size", [(640, 480), (480, 640), (160, 120)])
def test_each_thing_is_found_once_where_it_is(tmp_path: Path, export: str, size: tuple[int, int]) -> None:
    frame, part = frame_of(*size)
    segmenter = make_segmenter("sam", {"weights": EXPORTS[export].write(tmp_path), "points": 5})
    masks = segmenter.segment(frame)
    assert len(masks) == len(GREYS)
    mostly = [int(np.bincount(part[mask]).argmax()) for mask in masks.masks]
    assert sorted(mostly) == [0, 1, 2, 3]
    for mask, one in zip(masks.masks, mostly, strict=True):
        assert iou(mask, part == one) > 0.95  # the decoder's borders lie on a raster of a quarter of the resolution
    np.testing.assert_allclose(masks.scores, 0.95)


@pytest.mark.parametrize("export", EXPORTS)
def test_sam_keeps_the_shape_of_an_image_and_sam2_stretches_it(tmp_path: Path, export: str) -> None:
    frame, _ = frame_of(640, 480)
    model = SamSegmenter(EXPORTS[export].write(tmp_path)).model
    _, view = model.encode(frame.rgb)
    stretched = export in ("sam2", "sam2.1")
    assert (view.side, view.columns, view.rows) == (1024, 1024, 1024 if stretched else 768)
    corner = view.coordinates(np.array([[640.0, 480.0]]))
    np.testing.assert_allclose(corner, [[view.columns, view.rows]])


def test_an_image_lies_normalised_at_the_top_left_of_its_square() -> None:
    rgb = np.full((10, 20, 3), [0, 128, 255], np.uint8)
    square = SquareLayout.of(10, 20, 40, stretched=False).square(rgb, (0.5, 0.5, 0.5), (0.25, 0.5, 0.5))
    assert square.shape == (1, 3, 40, 40)
    np.testing.assert_allclose(square[0, :, :20, :].reshape(3, -1).T, [[-2, 0.0039216, 1]] * 800, atol=1e-5)
    assert (square[0, :, 20:] == 0).all()


@pytest.mark.parametrize("export", ["sam2", "slim-sam", "sam2.1"])
def test_batches_do_not_change_the_masks(tmp_path: Path, export: str) -> None:
    frame, _ = frame_of(320, 240)
    folder = EXPORTS[export].write(tmp_path)
    at_once, in_parts = (SamSegmenter(folder, points=6, batch=batch).segment(frame) for batch in (64, 7))
    np.testing.assert_array_equal(at_once.masks, in_parts.masks)


class Boxes:
    """A detector that knows two rectangles, and a thing that it does not see."""

    def segment(self, frame: Frame) -> Masks:
        masks = np.zeros((3, *frame.depth.shape), bool)
        masks[0, 20:100, 40:200] = True
        masks[2, 150:230, 10:90] = np.eye(80, dtype=bool)
        return Masks(masks, np.array([0.5, 0.9, 0.75], np.float32), ("desk", "lamp", "cup"))


class Blind:
    """A detector that finds nothing."""

    def segment(self, frame: Frame) -> Masks:
        return Masks.none(*frame.depth.shape)


@pytest.mark.parametrize("export", [name for name in EXPORTS if name != "slim-sam"])
def test_boxes_of_a_detector_become_masks_with_its_names(tmp_path: Path, export: str) -> None:
    frame, _ = frame_of(320, 240)
    masks = SamSegmenter(EXPORTS[export].write(tmp_path), boxes=Boxes()).segment(frame)
    assert masks.class_names == ("desk", "cup")
    assert masks.scores.tolist() == [0.5, 0.75]
    for mask, (top, below, left, right) in zip(masks.masks, [(20, 100, 40, 200), (150, 230, 10, 90)], strict=True):
        wanted = np.zeros_like(mask)
        wanted[top:below, left:right] = True
        assert iou(mask, wanted) > 0.95


def test_a_detector_that_finds_nothing_gives_nothing(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    assert len(SamSegmenter(EXPORTS["edge-sam"].write(tmp_path), boxes=Blind()).segment(frame)) == 0


def test_an_export_without_boxes_says_so(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    segmenter = SamSegmenter(EXPORTS["slim-sam"].write(tmp_path), boxes=Boxes())
    with pytest.raises(BadInput, match="takes points only"):
        segmenter.segment(frame)


def test_nothing_good_enough_is_no_mask(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    masks = SamSegmenter(EXPORTS["sam2.1"].write(tmp_path), points=4, min_quality=1.0).segment(frame)
    assert masks.masks.shape == (0, 240, 320)


def test_a_segmenter_travels_before_and_after_its_first_use(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    segmenter = SamSegmenter(EXPORTS["sam2"].write(tmp_path), points=5)
    before = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    after = segmenter.segment(frame)
    unpickled = pickle.loads(pickle.dumps(segmenter)).segment(frame)
    np.testing.assert_array_equal(before.masks, after.masks)
    np.testing.assert_array_equal(unpickled.masks, after.masks)


def test_the_two_files_may_be_named(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    export = EXPORTS["edge-sam"]
    export.write(tmp_path)
    (tmp_path / "another_encoder.onnx").write_bytes(b"")
    with pytest.raises(BadInput, match="another_encoder"):
        SamSegmenter(tmp_path)
    named = SamSegmenter(tmp_path / export.encoder, tmp_path / export.decoder, points=5)
    assert len(named.segment(frame)) == len(GREYS)


def test_grid_points_are_centres_of_square_cells_in_the_image() -> None:
    points = point_grid(120, 160, 4)
    np.testing.assert_allclose(np.unique(points[:, 0]), [20, 60, 100, 140])
    np.testing.assert_allclose(np.unique(points[:, 1]), [20, 60, 100])
    assert len(points) == 12
    assert point_grid(10, 1000, 4).shape == (4, 2)


def test_stability_is_the_share_of_the_area_that_stays() -> None:
    logits = rng.normal(size=(3, 8, 9)).astype(np.float32) * 2
    logits[2] = -5
    for each, value in zip(logits, stability(logits), strict=True):
        inner = sum(1 for v in each.ravel() if v > 1)
        outer = sum(1 for v in each.ravel() if v > -1)
        assert value == pytest.approx(inner / outer if outer else 0)


def literal_choice(masks: np.ndarray, scores: np.ndarray, most: float) -> list[int]:
    kept: list[int] = []
    for index in sorted(range(len(masks)), key=lambda i: -scores[i]):
        overlaps = []
        for other in kept:
            union = int((masks[index] | masks[other]).sum())
            overlaps.append(int((masks[index] & masks[other]).sum()) / union if union else 0.0)
        if all(value <= most for value in overlaps):
            kept.append(index)
    return kept


@pytest.mark.parametrize("most", [0.0, 0.3, 0.7, 1.0])
def test_of_overlapping_masks_the_best_stay(most: float) -> None:
    corners, sizes = rng.integers(0, 14, (40, 2)), rng.integers(0, 16, (40, 2))
    masks = np.zeros((40, 24, 30), bool)
    for mask, (y, x), (h, w) in zip(masks, corners, sizes, strict=True):
        mask[y : y + h, x : x + w] = True
    scores = rng.permutation(40).astype(np.float32)
    assert best_of_overlapping(masks, scores, most).tolist() == literal_choice(masks, scores, most)
    matrix = mask_iou(masks)
    assert matrix == pytest.approx(matrix.T)


def test_boxes_close_round_their_masks() -> None:
    masks = np.zeros((2, 6, 7), bool)
    masks[0, 2:4, 1:6] = True
    assert mask_boxes(masks).tolist() == [[1, 2, 6, 4], [0, 0, 0, 0]]


def renamed(model: onnx.ModelProto, old: str, new: str) -> onnx.ModelProto:
    for value in [*model.graph.input, *model.graph.output]:
        value.name = new if value.name == old else value.name
    for node in model.graph.node:
        for ports in (node.input, node.output):
            ports[:] = [new if name == old else name for name in ports]
    return model


def test_one_feature_map_may_go_by_another_name(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    export = EXPORTS["sam"]
    folder = export.write(tmp_path)
    onnx.save(renamed(export.encoder_graph(), "image_embeddings", "embeddings"), folder / export.encoder)
    assert len(SamSegmenter(folder, points=5).segment(frame)) == len(GREYS)


def test_a_decoder_may_fix_the_numbers_of_prompts_and_points(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    export = EXPORTS["sam2"]
    export.write(tmp_path / "open")
    model = export.decoder_graph()
    for value in [*model.graph.input, *model.graph.output]:
        for side in value.type.tensor_type.shape.dim:
            if side.dim_param in ("P", "K"):
                side.dim_value = {"P": 8, "K": 2}[side.dim_param]
    export.write(tmp_path / "fixed")
    onnx.save(model, tmp_path / "fixed" / export.decoder)
    fixed = SamSegmenter(tmp_path / "fixed", boxes=Boxes()).segment(frame)
    free = SamSegmenter(tmp_path / "open", boxes=Boxes()).segment(frame)
    np.testing.assert_array_equal(fixed.masks, free.masks)
    assert fixed.masks.any(axis=(1, 2)).all()


def test_files_of_two_exports_do_not_go_together(tmp_path: Path) -> None:
    for name in ("sam2.1", "edge-sam"):
        EXPORTS[name].write(tmp_path / name)
    encoder = tmp_path / "edge-sam" / EXPORTS["edge-sam"].encoder
    with pytest.raises(BadInput, match="not of one export"):
        SamSegmenter(encoder, tmp_path / "sam2.1" / EXPORTS["sam2.1"].decoder)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"points": 0}, "points"),
        ({"min_quality": 1.5}, "are from 0 to 1"),
        ({"device": "tpu"}, "device is auto, cpu or cuda"),
        ({"boxes": "unheard"}, "unknown segmenter"),
        ({"fancy": 1}, "does not take these options"),
    ],
)
def test_impossible_options_are_refused(tmp_path: Path, options: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        make_segmenter("sam", {"weights": EXPORTS["edge-sam"].write(tmp_path), **options})


def test_of_several_pairs_in_a_folder_the_known_one_is_taken(tmp_path: Path) -> None:
    for name in ("encoder.onnx", "decoder_multi.onnx", "decoder_single.onnx"):
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(BadInput, match="give a folder with just the two"):
        encoder_and_decoder(tmp_path)
    files = encoder_and_decoder(tmp_path, ("encoder.onnx", "decoder_single.onnx"))
    assert [file.name for file in files] == ["encoder.onnx", "decoder_single.onnx"]


def test_what_is_no_pair_is_refused_at_once(tmp_path: Path) -> None:
    export = EXPORTS["edge-sam"]
    export.write(tmp_path / "pair")
    encoder, decoder = tmp_path / "pair" / export.encoder, tmp_path / "pair" / export.decoder
    with pytest.raises(BadInput, match=r"no model file .*missing\.onnx"):
        SamSegmenter(tmp_path / "missing.onnx")
    with pytest.raises(BadInput, match="SAM exports are two"):
        SamSegmenter(encoder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(BadInput, match="holds no ONNX file"):
        SamSegmenter(tmp_path / "empty")
    with pytest.raises(BadInput, match="is no SAM encoder"):
        SamSegmenter(decoder, decoder)
    with pytest.raises(BadInput, match="is no SAM decoder"):
        SamSegmenter(encoder, encoder)
    cut = tmp_path / "cut.onnx"
    cut.write_bytes(encoder.read_bytes()[:100])
    with pytest.raises(BadInput, match="is no ONNX model, or is damaged"):
        SamSegmenter(cut, decoder)


def test_masks_of_an_unknown_shape_are_named(tmp_path: Path) -> None:
    frame, _ = frame_of(320, 240)
    export = EXPORTS["sam2"]
    folder = export.write(tmp_path)
    model = export.decoder_graph()
    last = next(node for node in model.graph.node if "masks" in node.output)
    last.op_type, last.input[:] = "Squeeze", ["as_four"]
    onnx.save(model, folder / export.decoder)
    with pytest.raises(BadInput, match="no known SAM decoder"):
        SamSegmenter(folder, points=5).segment(frame)
