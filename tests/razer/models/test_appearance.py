"""The appearance embedder: what must not matter, what must, and real masks in neighbouring frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from data_tools import open_sequence
from razer.frame import Frame, Masks
from razer.geometry import back_project, inverse, project, transform_points
from razer.models import TextEncoder, make_embedder
from razer.models.appearance import AppearanceEmbedder
from razer.models.geometric.segmenter import GeometricSegmenter
from tests.support.depth_scenes import frame_of

RED, GREEN, GREY = (200, 40, 40), (40, 160, 60), (120, 120, 120)


def painted(*patches: tuple[int, int, tuple[int, int, int]], depth_m: float = 1.5) -> tuple[Frame, Masks]:
    """A frame with a square patch of 100 pixels at each (row, column) in each colour, and the patches' masks."""
    rng = np.random.default_rng(0)
    rgb = np.full((480, 640, 3), 90, np.uint8)
    masks = np.zeros((len(patches), 480, 640), bool)
    for mask, (row, column, colour) in zip(masks, patches, strict=True):
        mask[row : row + 100, column : column + 100] = True
        rgb[mask] = colour
    noisy = np.clip(rgb + rng.normal(0, 2, rgb.shape), 0, 255).astype(np.uint8)
    return frame_of(np.full((480, 640), depth_m), noisy), Masks(masks, np.ones(len(masks), np.float32))


def test_vectors_have_unit_length_and_one_size() -> None:
    frame, masks = painted((50, 50, RED), (200, 400, GREY))
    vectors = make_embedder("appearance", {}).embed(frame, masks)
    assert vectors.dtype == np.float32
    assert vectors.shape == (2, AppearanceEmbedder.dimension)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-6)
    assert not isinstance(AppearanceEmbedder(), TextEncoder)


def test_the_place_in_the_image_does_not_matter_and_the_colour_does() -> None:
    frame, masks = painted((50, 50, RED), (203, 401, RED), (50, 402, GREEN), (300, 100, GREY))
    similarity = (vectors := AppearanceEmbedder().embed(frame, masks)) @ vectors.T
    assert similarity[0, 1] > 0.98
    assert max(similarity[0, 2], similarity[0, 3], similarity[2, 3]) < 0.6


def test_a_little_less_light_matters_little() -> None:
    (bright, masks), (dim, _) = painted((50, 50, RED)), painted((50, 50, tuple(int(0.9 * c) for c in RED)))
    cosine = (AppearanceEmbedder().embed(bright, masks) @ AppearanceEmbedder().embed(dim, masks).T).item()
    assert cosine > 0.8


def test_texture_and_size_matter() -> None:
    frame, masks = painted((50, 50, GREY), (200, 400, GREY))
    striped = frame.rgb.copy()
    striped[200:300, 400:500] = np.where(np.arange(100) % 20 < 10, 60, 180)[None, :, None]
    plain = AppearanceEmbedder().embed(frame, masks)
    assert (plain[0] @ AppearanceEmbedder().embed(frame_of(frame.depth, striped), masks)[1]) < 0.8
    far, _ = painted((50, 50, GREY), depth_m=4.5)
    assert 0.5 < plain[0] @ AppearanceEmbedder().embed(far, masks.select(np.array([0])))[0] < 0.97


def test_a_mask_is_described_alone_as_among_others() -> None:
    frame, masks = painted((50, 50, RED), (200, 400, GREEN), (300, 100, GREY))
    together = AppearanceEmbedder().embed(frame, masks)
    for i in range(3):
        np.testing.assert_array_equal(AppearanceEmbedder().embed(frame, masks.select(np.array([i])))[0], together[i])


@pytest.mark.parametrize("pixels", [0, 1, 3])
def test_masks_of_hardly_any_pixels_still_get_unit_vectors(pixels: int) -> None:
    frame, masks = painted((50, 50, RED))
    masks.masks[:] = False
    masks.masks[0, 51, 51 : 51 + pixels] = True
    vectors = AppearanceEmbedder().embed(frame, masks)
    assert np.isfinite(vectors).all()
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-6)


def test_no_masks_and_no_depth_are_fine() -> None:
    frame, masks = painted((50, 50, RED), depth_m=0.0)
    assert AppearanceEmbedder().embed(frame, Masks.none(480, 640)).shape == (0, AppearanceEmbedder.dimension)
    np.testing.assert_allclose(np.linalg.norm(AppearanceEmbedder().embed(frame, masks)), 1, atol=1e-6)


def seen_again(before: Frame, masks: Masks, after: Frame, others: Masks) -> list[tuple[int, int]]:
    """Pairs of masks that show the same surface, by the given poses: intersection over union above 0.6."""
    v, u = np.nonzero((before.depth > 0) & (before.depth < 5))
    points = back_project(u, v, before.depth[v, u], before.intrinsics.matrix)
    points = transform_points(inverse(after.pose) @ before.pose, points)
    u2, v2, z = project(points, after.intrinsics.matrix)
    inside = (z > 0) & (u2 > -0.5) & (u2 < 639.5) & (v2 > -0.5) & (v2 < 479.5)
    u, v, u2, v2 = u[inside], v[inside], np.rint(u2[inside]).astype(int), np.rint(v2[inside]).astype(int)
    same = np.abs(after.depth[v2, u2] - z[inside]) < 0.03 * z[inside]
    a, b = masks.masks[:, v[same], u[same]].astype(float), others.masks[:, v2[same], u2[same]].astype(float)
    common = a @ b.T
    union = a.sum(axis=1)[:, None] + b.sum(axis=1)[None] - common
    return list(zip(*np.nonzero(common > 0.6 * np.maximum(union, 400)), strict=True))


def test_real_masks_are_more_like_themselves_five_frames_later_than_like_others(real_data: Path) -> None:
    kitchen, same, unlike = open_sequence(real_data / "redkitchen"), [], []
    for first in (0, 150, 300, 450):
        before, after = kitchen[first], kitchen[first + 5]
        masks, others = (GeometricSegmenter().segment(frame) for frame in (before, after))
        cosines = AppearanceEmbedder().embed(before, masks) @ AppearanceEmbedder().embed(after, others).T
        pairs = seen_again(before, masks, after, others)
        different = np.ones(cosines.shape, bool)
        for i, j in pairs:
            same.append(cosines[i, j])
            different[i, :] &= np.arange(cosines.shape[1]) != j
        unlike.extend(cosines[different])
    assert len(same) > 30
    assert np.median(same) > 0.9
    assert np.median(unlike) < 0.6
    ranks = np.searchsorted(np.sort(unlike), same) / len(unlike)  # their mean is the area under the ROC curve
    assert ranks.mean() > 0.95
