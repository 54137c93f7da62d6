"""Oracle segmentation: masks from a frame's ground-truth instance ids, with simulated errors."""

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
from razer.models.oracle.profiles.table import segmenter_profile
from razer.models.oracle.profiles.visible_things import UNKNOWN, VisibleThings
from razer.models.stuff_names import stuff_classes


class OracleSegmenter:
    """Masks from a frame's own instance ids, with class names and score 1, or as a profile of real models' errors has
    them.

    Args:
        noise: "none", or "full": 15 % of the masks dropped, 10 % split, 5 % merged, borders moved by up to 3 px.
        seed: of all random draws.
        drop: share of masks missing from a frame; this and the following replace what `noise` sets (see MaskNoise).
        hold: frames for which a dropped mask stays away.
        split: share of instances cut in two.
        split_frames: frames for which an instance stays cut.
        merge: share of masks that absorb an adjacent one.
        jitter_px: largest distance that a border moves, pixels.
        stuff: whether walls, floors, ceilings and the like are flagged as stuff, by their names. Off, they are mapped
            as things, one by one.
        profile: instead of all these errors those of one kind of model: sam, detector,
            detector-hard, panoptic or panoptic-hard.

    Raises:
        BadInput: for impossible options.
    """

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
        stuff: bool = False,
        profile: str | None = None,
    ) -> None:
        check_noise_preset(noise)
        options: dict[str, Any] = {
            "drop": drop,
            "hold": hold,
            "split": split,
            "split_frames": split_frames,
            "merge": merge,
            "jitter_px": jitter_px,
        }
        if profile is not None and (noise != "none" or stuff or any(value is not None for value in options.values())):
            raise BadInput(f"the oracle segmenter's profile {profile} has its own errors and stuff: leave out noise")
        self.stuff = stuff
        self.profile = None if profile is None else segmenter_profile(profile, seed)
        preset = FULL_NOISE if noise == "full" else MaskNoise()
        self.noise = replace(preset, seed=seed, **{k: v for k, v in options.items() if v is not None})

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when the frame has no instance ids."""
        ids = VisibleThings.of(frame, "segmenter").ids
        if self.profile is not None:
            return self.profile.masks(frame)
        parts = list(self._masks(frame.index, ids))
        if not parts:
            return Masks.none(*ids.shape)
        masks = np.zeros((len(parts), *ids.shape), np.bool_)
        for canvas, (_, window, mask) in zip(masks, parts, strict=True):
            canvas[window] = mask
        names = tuple(frame.instance_classes.get(instance, UNKNOWN) for instance, _, _ in parts)
        flags = stuff_classes(names) if self.stuff else None
        return Masks(masks, np.ones(len(parts), np.float32), names, flags)

    def _masks(self, index: int, ids: Int32Array) -> Iterator[tuple[int, tuple[slice, slice], BoolArray]]:
        """Instance, window of the image and mask within the window, in order of instance."""
        boxes = {i: box for i, box in enumerate(ndimage.find_objects(ids.clip(0)), start=1) if box is not None}
        kept = [i for i in boxes if self.noise.is_kept(index, i)]
        absorbed_by = self.noise.absorbed_by(index, ids, kept)
        for instance in kept:
            if instance in absorbed_by:
                continue
            members = [instance, *(absorbed for absorbed, by in absorbed_by.items() if by == instance)]
            window = _window([boxes[m] for m in members], self.noise.jitter_px, ids.shape)
            mask = np.isin(ids[window], members) if len(members) > 1 else ids[window] == instance
            for part, part_mask in enumerate(self.noise.split_parts(index, instance, mask)):
                jittered = self.noise.jittered(index, instance, part, part_mask)
                if jittered.any():
                    yield instance, window, jittered


def _window(boxes: list[tuple[slice, slice]], margin: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The smallest window round all boxes, with a margin, inside the image."""
    top, bottom = min(b[0].start for b in boxes) - margin, max(b[0].stop for b in boxes) + margin
    left, right = min(b[1].start for b in boxes) - margin, max(b[1].stop for b in boxes) + margin
    return slice(max(top, 0), min(bottom, shape[0])), slice(max(left, 0), min(right, shape[1]))
