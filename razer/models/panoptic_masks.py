"""Panoptic inference from the queries of a universal segmentation model (Cheng et al. 2022)."""

from __future__ import annotations

import torch
from torch import Tensor

_MASK_THRESHOLD = 0.5  # probability from which a pixel belongs to a mask
_MIN_VISIBLE_SHARE = 0.8  # of its mask that a query must win from the others


def panoptic_masks(
    class_logits: Tensor, mask_logits: Tensor, size: tuple[int, int], confidence: float
) -> tuple[Tensor, Tensor, Tensor]:
    """Masks (N, H, W) that do not overlap, scores (N,) and classes (N,).

    Args:
        class_logits: (Q, C + 1) of Q queries, the last class being "no object".
        mask_logits: (Q, h, w).
        size: (H, W) of the image.
        confidence: lowest score of a mask.
    """
    scores, classes = class_logits.softmax(dim=-1).max(dim=-1)
    is_object = (classes != class_logits.shape[-1] - 1) & (scores > confidence)
    scores, classes = scores[is_object], classes[is_object]
    if not len(scores):
        return torch.zeros((0, *size), dtype=torch.bool), scores, classes
    probability = torch.nn.functional.interpolate(mask_logits[None, is_object], size, mode="bilinear")[0].sigmoid()
    owner = (scores[:, None, None] * probability).argmax(dim=0)
    whole = probability >= _MASK_THRESHOLD
    visible = whole & (owner == torch.arange(len(scores), device=owner.device)[:, None, None])
    area = visible.sum(dim=(1, 2))
    kept = (area > 0) & (area >= _MIN_VISIBLE_SHARE * whole.sum(dim=(1, 2)))
    return visible[kept], scores[kept], classes[kept]
