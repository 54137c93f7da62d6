"""From the queries of a universal segmentation model to one mask for each pixel (Cheng et al. 2022)."""

from __future__ import annotations

import torch
from torch import Tensor

_SURE = 0.5  # from which a pixel belongs to a mask
_LEFT = 0.8  # share of its mask that a query must win from the others


def panoptic_masks(
    class_logits: Tensor, mask_logits: Tensor, size: tuple[int, int], confidence: float
) -> tuple[Tensor, Tensor, Tensor]:
    """Masks (N, H, W) that do not overlap, scores (N,) and classes (N,), for an image of `size` (H, W), of Q queries:
    class_logits (Q, C + 1), the last class being nothing, and mask_logits (Q, h, w)."""
    scores, classes = class_logits.softmax(dim=-1).max(dim=-1)
    found = (classes != class_logits.shape[-1] - 1) & (scores > confidence)
    scores, classes = scores[found], classes[found]
    if not len(scores):
        return torch.zeros((0, *size), dtype=torch.bool), scores, classes
    inside = torch.nn.functional.interpolate(mask_logits[None, found], size, mode="bilinear")[0].sigmoid()
    owner = (scores[:, None, None] * inside).argmax(dim=0)
    whole = inside >= _SURE
    won = whole & (owner == torch.arange(len(scores), device=owner.device)[:, None, None])
    area = won.sum(dim=(1, 2))
    kept = (area > 0) & (area >= _LEFT * whole.sum(dim=(1, 2)))
    return won[kept], scores[kept], classes[kept]
