"""Masks from files: whether they are there for the frames of a run, before it begins."""

from __future__ import annotations

from rich.console import Console

from razer.models import Segmenter
from razer.models.combined.segmenter import CombinedSegmenter
from razer.models.stored_masks import StoredMasks


def note_stored_masks(segmenter: Segmenter, indices: range, console: Console) -> None:
    """Say how many of the frames have masks, where these come from files and some have none; raises BadInput where
    none of them has. Of a combination, each part that reads files."""
    if isinstance(segmenter, CombinedSegmenter):
        for part in segmenter.parts.values():
            note_stored_masks(part, indices, console)
    if not isinstance(segmenter, StoredMasks):
        return
    count = segmenter.count_frames(indices)
    if count < len(indices):
        console.print(
            f"note: {segmenter.folder} has masks for {count} of {len(indices)} frames; the others show nothing",
            soft_wrap=True,
        )
