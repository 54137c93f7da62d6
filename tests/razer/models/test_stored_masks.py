"""Masks read from files, and files that cannot be masks."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.models import make_segmenter
from razer.models.stored_masks import StoredMasks

IDS = np.array([[0, 300, 300, 0], [7, 7, 0, 0], [7, 0, 0, 2]], np.uint16)
SHAPE = IDS.shape


def frame(index: int = 7) -> Frame:
    camera = Intrinsics(SHAPE[1], SHAPE[0], 10.0, 10.0, 2.0, 1.5)
    return Frame(index, 0.0, np.zeros((*SHAPE, 3), np.uint8), np.ones(SHAPE, np.float32), camera)


def write_ids(folder: Path, ids: np.ndarray = IDS) -> Path:
    cv2.imwrite(str(folder / "000007.png"), ids)
    return folder


def test_ids_of_a_png_become_masks_in_increasing_order(tmp_path: Path) -> None:
    masks = make_segmenter("masks", {"folder": str(write_ids(tmp_path))}).segment(frame())
    np.testing.assert_array_equal(masks.masks, np.stack([IDS == 2, IDS == 7, IDS == 300]))
    np.testing.assert_array_equal(masks.scores, [1, 1, 1])
    assert masks.class_names is None


def test_a_frame_without_a_file_has_no_masks(tmp_path: Path) -> None:
    assert StoredMasks(write_ids(tmp_path)).segment(frame(8)).masks.shape == (0, *SHAPE)


def test_an_archive_may_hold_masks_that_overlap_with_scores_and_names(tmp_path: Path) -> None:
    stack = np.stack([IDS > 0, IDS == 7])
    np.savez(tmp_path / "000007.npz", masks=stack, scores=np.array([0.5, 0.25]), names=np.array(["desk", "cup"]))
    masks = StoredMasks(tmp_path).segment(frame())
    np.testing.assert_array_equal(masks.masks, stack)
    np.testing.assert_array_equal(masks.scores, np.array([0.5, 0.25], np.float32))
    assert masks.class_names == ("desk", "cup")


def test_an_archive_may_hold_ids(tmp_path: Path) -> None:
    np.savez(tmp_path / "000007.npz", ids=IDS.astype(np.int64))
    np.testing.assert_array_equal(StoredMasks(tmp_path).segment(frame()).masks[2], IDS == 300)


def test_a_missing_folder_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="nowhere"):
        make_segmenter("masks", {"folder": str(tmp_path / "nowhere")})


@pytest.mark.parametrize("name", ["frame-000007.png", "7.png", "000007.jpg", "7.000007.npz", None])
def test_a_folder_whose_names_are_no_frames_is_refused_at_once(tmp_path: Path, name: str | None) -> None:
    if name:
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(BadInput, match=r"000007\.png or 000007\.npz") as caught:
        StoredMasks(tmp_path)
    assert str(tmp_path) in str(caught.value)
    assert (name or "is empty") in str(caught.value)


def test_frames_with_a_file_are_counted_and_none_is_refused(tmp_path: Path) -> None:
    (write_ids(tmp_path) / "000009.npz").write_bytes(b"")
    assert StoredMasks(tmp_path).count_frames(range(8)) == 1
    assert StoredMasks(tmp_path).count_frames(range(1, 20, 2)) == 2
    with pytest.raises(BadInput, match=r"none of the 4 frames, which are numbered 0 to 6.*000007\.png"):
        StoredMasks(tmp_path).count_frames(range(0, 8, 2))


STACK = np.zeros((2, *SHAPE), bool)


@pytest.mark.parametrize(
    "arrays",
    [
        {"ids": IDS[:, :3]},
        {"ids": IDS.astype(float)},
        {"masks": STACK[:, :2]},
        {"masks": STACK[0]},
        {"masks": STACK, "scores": np.ones(3)},
        {"masks": STACK, "scores": np.array([0.5, np.nan])},
        {"masks": STACK, "scores": np.array([0.5, 1.5])},
        {"masks": STACK, "names": np.array(["one"])},
        {"scores": np.ones(2)},
        {"masks": np.array([None, "x"], object)},
    ],
)
def test_an_archive_that_does_not_fit_is_named(tmp_path: Path, arrays: dict[str, np.ndarray]) -> None:
    np.savez(tmp_path / "000007.npz", **arrays)
    with pytest.raises(UnusableFrame, match=r"000007\.npz"):
        StoredMasks(tmp_path).segment(frame())


@pytest.mark.parametrize("suffix", ["png", "npz"])
@pytest.mark.parametrize("content", [b"", b"not an image", b"PK\x03\x04 broken"])
def test_a_broken_file_is_named(tmp_path: Path, suffix: str, content: bytes) -> None:
    (tmp_path / f"000007.{suffix}").write_bytes(content)
    with pytest.raises(UnusableFrame, match=rf"000007\.{suffix}"):
        StoredMasks(tmp_path).segment(frame())


@pytest.mark.parametrize("ids", [IDS[:2], np.dstack([IDS] * 3), IDS.T])
def test_a_picture_that_is_no_id_image_of_this_size_is_named(tmp_path: Path, ids: np.ndarray) -> None:
    with pytest.raises(UnusableFrame, match=r"000007\.png"):
        StoredMasks(write_ids(tmp_path, ids)).segment(frame())
