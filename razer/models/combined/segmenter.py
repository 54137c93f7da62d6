"""A segmenter made of several: things of detectors over the stuff of a semantic model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import Segmenter, make_segmenter, tells_instances
from razer.models.combined.overlap_rule import PartMasks, combine
from razer.models.combined.part_names import part_names, part_options
from razer.models.recorded_view import masks_of


class CombinedSegmenter:
    """Several segmenters on each frame; how their masks share it is said by `combine`.

    Args:
        parts: the segmenters by label, or a name such as "yolo+semantic" (see part_names).
        iou: overlap of masks above which two segmenters mean one thing. Lower: things that stand close become one;
            higher: one thing has two masks. Of 238 pairs of masks of two YOLO models that overlap on real frames 207
            do so by more than 0.5, one thing under one name or two; 26 by less than 0.3, most of them nested or
            beside each other; 5 lie in between.
        options: of each part by its label, where parts is a name.

    Raises:
        BadInput: for names and options that there are not.
    """

    def __init__(self, parts: str | Mapping[str, Segmenter], iou: float = 0.5, **options: Any) -> None:
        if not (isinstance(iou, int | float) and 0 < iou <= 1):
            raise BadInput(f"segmenter.options.iou is above 0 and up to 1, not {iou!r}")
        self.parts = _made(parts, options) if isinstance(parts, str) else dict(parts)
        self.iou = iou

    @property
    def tells_instances(self) -> bool:
        """Whether all parts do."""
        return all(tells_instances(part) for part in self.parts.values())

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, things first, then pieces of classes, then stuff; stuff is flagged."""
        found = [PartMasks(masks_of(part, frame), tells_instances(part)) for part in self.parts.values()]
        return combine(found, self.iou)


def _made(name: str, options: Mapping[str, Any]) -> dict[str, Segmenter]:
    names = part_names(name)
    by_part = part_options(name, names, options)
    return {label: _part(label, segmenter, by_part[label]) for label, segmenter in names.items()}


def _part(label: str, segmenter: str, options: Mapping[str, Any]) -> Segmenter:
    try:
        return make_segmenter(segmenter, options)
    except BadInput as error:
        if label == segmenter:
            raise
        raise type(error)(f"{label}: {error}") from error
