"""Masks from a frame's own instance ids, with as much noise as asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy import ndimage

from razer.arrays import BoolArray, Int32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.oracle.mask_noise import FULL_NOISE, MaskNoise, check_noise_preset

UNKNOWN = "unknown"


class OracleSegmenter:
    """Masks from a frame's own instance ids, with class names and score 1.

    noise "full" drops 15 % of the masks, splits 10 %, merges 5 % and moves borders by up to 3 px; every part can
    be set by itself (see MaskNoise), also hold=10, which keeps a dropped mask away for ten frames. Raises
    BadInput."""

    def __init__(
        self,
        noise: Literal["none", "full"] = "none",
        seed: int = 0,
        *,
        drop: float | None = None,
        hold: int | None = None,
        split: float | None = None,
        split_frames: int | None = None,
        merge: float | None = None,
        jitter_px: int | None = None,
    ) -> None:
        check_noise_preset(noise)
        given: dict[str, Any] = {
            "drop": drop,
            "hold": hold,
            "split": split,
            "split_frames": split_frames,
            "merge": merge,
            "jitter_px": jitter_px,
        }
        preset = FULL_NOISE if noise == "full" else MaskNoise()
        self.noise = replace(preset, seed=seed, **{k: v for k, v in given.items() if v is not None})

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when the frame has no instance ids."""
        if frame.instance_ids is None:
            raise BadInput(
                f"frame {frame.index} has no instance ids, which the oracle segmenter needs: "
                "use a recording with ids/, or --segmenter geometric"
            )
        found = list(self._masks(frame.index, frame.instance_ids))
        if not found:
            return Masks.none(*frame.instance_ids.shape)
        masks = np.zeros((len(found), *frame.instance_ids.shape), np.bool_)
        for canvas, (_, window, mask) in zip(masks, found, strict=True):
            canvas[window] = mask
        names = tuple(frame.instance_classes.get(instance, UNKNOWN) for instance, _, _ in found)
        return Masks(masks, np.ones(len(found), np.float32), names)

    def _masks(self, index: int, ids: Int32Array) -> Iterator[tuple[int, tuple[slice, slice], BoolArray]]:
        """Instance, window of the image and mask within the window, in order of instance."""
        boxes = {i: box for i, box in enumerate(ndimage.find_objects(ids.clip(0)), start=1) if box is not None}
        kept = [i for i in boxes if self.noise.keeps(index, i)]
        swallowed = self.noise.merged(index, ids, kept)
        for instance in kept:
            if instance in swallowed:
                continue
            members = [instance, *(prey for prey, eater in swallowed.items() if eater == instance)]
            window = _window([boxes[m] for m in members], self.noise.jitter_px, ids.shape)
            mask = np.isin(ids[window], members) if len(members) > 1 else ids[window] == instance
            for part, piece in enumerate(self.noise.pieces(index, instance, mask)):
                frayed = self.noise.frayed(index, instance, part, piece)
                if frayed.any():
                    yield instance, window, frayed


def _window(boxes: list[tuple[slice, slice]], margin: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The smallest window round all boxes, with a margin, inside the image."""
    top, bottom = min(b[0].start for b in boxes) - margin, max(b[0].stop for b in boxes) + margin
    left, right = min(b[1].start for b in boxes) - margin, max(b[1].stop for b in boxes) + margin
    return slice(max(top, 0), min(bottom, shape[0])), slice(max(left, 0), min(right, shape[1]))
