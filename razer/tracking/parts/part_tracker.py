"""Tracking of parts: masks within the masks of a thing become its parts if view after view shows them.

Nested masks speak for one thing (`view_consensus`), so the whole is the track. What a mask within it said is kept here,
beside the tracks: parts have no ids in the volume, take no voxels, and change nothing of the whole."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from razer.arrays import Int64Array
from razer.config import MapperConfig
from razer.detection.lifting import Detection
from razer.detection.observed_surface import Cells
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.evidence.view_consensus import MIN_VISIBLE_CELLS, nested_log_odds
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.parts.cell_votes import cell_keys
from razer.tracking.parts.part_track import PartTrack
from razer.tracking.step_result import Decision
from razer.tracking.tracker import PRUNED

PART_SHARE = 0.8  # of its whole's cells that a part has at most: more is the whole, seen less well
SAME_PART_IOU = 0.5  # of a mask and what the frame shows of a part
# A mask that is within no other is rather the whole, cut by the image or half hidden.
SAME_PART_IOU_ALONE = 0.8


@dataclass(frozen=True)
class PartFrame:
    """What one frame shows: its observed cells, N detections, their decisions, the labels under them, and the share of
    a view that it is; is_beside, whether the map lies beside the poses, so that nothing can be missed."""

    index: int
    cells: Cells
    detections: Sequence[Detection]
    decisions: Sequence[Decision]
    overlap: LabelOverlap
    novelty: float
    is_beside: bool = False

    @cached_property
    def owner_of(self) -> dict[int, int]:
        """The track of each detection of a thing, in no order of masks; stuff has no parts."""
        owners = {d.detection: d.track_id for d in self.decisions}
        things = [i for i in owners if not self.detections[i].is_stuff]
        return {i: owners[i] for i in sorted(things, key=lambda i: _content(self.detections[i]))}

    @cached_property
    def nested(self) -> frozenset[tuple[int, int]]:
        """Pairs of a detection and the track of a larger mask that its own lies in."""
        of_mask: dict[int, list[int]] = defaultdict(list)
        for i in self.owner_of:
            of_mask[self.detections[i].mask].append(i)
        return frozenset(
            (i, self.owner_of[outer])
            for pair in self.overlap.nested
            for i in of_mask[pair[0]]
            for outer in of_mask[pair[1]]
            if self.detections[i].n_cells <= PART_SHARE * self.detections[outer].n_cells
        )


class PartTracker:
    """The parts of all tracks, by the id of their whole."""

    def __init__(self, config: MapperConfig, scale: SimilarityScale) -> None:
        """`scale` is that of the embedder's cosines, shared with the tracks."""
        self._config, self._scale = config, scale
        self._newest = 0
        self.parts: dict[int, list[PartTrack]] = {}

    def update(self, frame: PartFrame) -> None:
        """Take in one frame after the tracks did."""
        in_view = {*frame.overlap.visible, *frame.owner_of.values()}
        wholes = {whole for _, whole in frame.nested} | (self.parts.keys() & in_view)
        if not wholes:
            return
        observed = cell_keys(frame.cells)
        for whole in sorted(wholes):
            parts = self.parts.get(whole, [])
            if founded := self._update_whole(frame, whole, parts, observed):
                self.parts[whole] = [*parts, *founded]

    def _update_whole(
        self, frame: PartFrame, whole: int, parts: Sequence[PartTrack], observed: Int64Array
    ) -> list[PartTrack]:
        """Give the detections of a whole to its parts; returns those that are founded on nested ones left over."""
        owners = {whole}.union(*(part.owners for part in parts))
        inner = {i for i, outer in frame.nested if outer == whole}
        found = {i: owner for i, owner in frame.owner_of.items() if i in inner or owner in owners}
        in_mask = {i: observed[frame.detections[i].cells] for i in found}
        visible = [part.visible(observed) for part in parts]
        matched = _best_pairs(parts, in_mask, visible, inner)
        if not frame.is_beside:
            _count_misses(parts, visible, matched.values(), frame.novelty)
        has_own_mask = any(owner == whole and i not in inner for i, owner in found.items())
        founded = []
        for i, owner in found.items():
            if i in matched:
                parts[matched[i]].observe(frame.detections[i], frame.index, frame.novelty)
                part = parts[matched[i]]
            elif i in inner:
                part = self._founded(frame, i)
                founded.append(part)
            else:
                continue
            part.vote(in_mask[i], observed, frame.novelty, owner)
            part.nested += frame.novelty * (i in inner)
            part.beside += frame.novelty * (i not in inner and owner != whole and has_own_mask)
        return founded

    def _founded(self, frame: PartFrame, i: int) -> PartTrack:
        self._newest += 1
        return PartTrack(self._newest, frame.detections[i], frame.index, self._config, self._scale)

    def replace(self, gone: int, survivor: int) -> None:
        """The parts of a track that was fused or renamed are another's now; they are forgotten with it (survivor 0)."""
        parts = self.parts.pop(gone, [])
        if survivor and parts:
            self.parts[survivor] = _without_doubles([*self.parts.get(survivor, ()), *parts])
        for each in (part for parts in self.parts.values() for part in parts):
            each.rename_owner(gone, survivor)

    def tracked_parts(self) -> list[tuple[int, int, float]]:
        """Tracks that are parts of others by the masks of all views: (part, whole, log-odds), the surest first. So it
        is where both were found long before a mask showed them as one."""
        found: dict[tuple[int, int], float] = {}
        for whole, parts in self.parts.items():
            for part in parts:
                log_odds = nested_log_odds(part.nested, part.beside)
                if part.owner not in (0, whole) and log_odds > found.get((part.owner, whole), 0.0):
                    found[part.owner, whole] = log_odds
        return sorted(((*pair, odds) for pair, odds in found.items()), key=lambda pair: (-pair[2], pair))

    def prune(self) -> None:
        """Forget what is rather no part by now."""
        kept = {w: [p for p in parts if p.track.existence.log_odds >= PRUNED] for w, parts in self.parts.items()}
        self.parts = {whole: parts for whole, parts in kept.items() if parts}


def _content(detection: Detection) -> tuple[int, bytes]:
    return -detection.n_cells, detection.cells.tobytes()


def _best_pairs(
    parts: Sequence[PartTrack], keys: Mapping[int, Int64Array], visible: Sequence[Int64Array], inner: set[int]
) -> dict[int, int]:
    """{detection: number of its part} by the IoU with what the frame shows of each part, the best pairs first."""
    pairs = []
    for rank, (i, in_mask) in enumerate(keys.items()):
        enough = SAME_PART_IOU if i in inner else SAME_PART_IOU_ALONE
        ious = [part.visible_iou(in_mask, shown) for part, shown in zip(parts, visible, strict=True)]
        pairs += [(-iou, rank, number, i) for number, iou in enumerate(ious) if iou >= enough]
    matched: dict[int, int] = {}
    for _, _, number, i in sorted(pairs):
        if i not in matched and number not in matched.values():
            matched[i] = number
    return matched


def _count_misses(
    parts: Sequence[PartTrack], visible: Sequence[Int64Array], matched: Collection[int], novelty: float
) -> None:
    """Count a miss of each part that is in plain view, given by what the frame shows of it, and was not found."""
    for number, (part, shown) in enumerate(zip(parts, visible, strict=True)):
        if number not in matched and len(shown) >= MIN_VISIBLE_CELLS:
            part.track.count_miss(len(shown), novelty)


def _without_doubles(parts: Sequence[PartTrack]) -> list[PartTrack]:
    """Parts of which those that hold much the same cells are one."""
    kept: list[PartTrack] = []
    for part in parts:
        double = next((other for other in kept if part.cell_iou(other) > SAME_PART_IOU), None)
        if double is None:
            kept.append(part)
        else:
            double.absorb(part)
    return kept
