"""What became of each track: when it was seen, what happened to it, and the picture that shows it best."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import cv2

from app.timeline.objects.decision_words import Event, step_events
from razer.arrays import Uint8Array
from razer.detection.best_views import Region
from razer.frame import Frame
from razer.tracking.step_result import StepResult
from razer.tracking.track import Track

CROP_PX = 96  # edges of the pictures that are kept
QUIET_FRAMES = 30  # between two lines that say much the same
MARGIN = 0.15  # of a crop, round what it shows


@dataclass
class Life:
    """Of one track: the frames in which it was seen, what happened and when, and its best view (h, w, 3)."""

    seen: list[int] = field(default_factory=list)
    events: list[tuple[int, str]] = field(default_factory=list)
    crop: Uint8Array | None = None
    crop_score: float = 0.0


class ObjectHistory:
    """The lives of all tracks of a run, by id; one that was fused lives on in its survivor's."""

    def __init__(self) -> None:
        self.lives: dict[int, Life] = {}

    def add(self, frame: Frame, step: StepResult, tracks: Sequence[Track]) -> list[Event]:
        """Take in a frame; returns what happened in it."""
        names = {track.id: track.class_name for track in tracks if track.class_name}
        last_seen = {track_id: life.seen[-1] for track_id, life in self.lives.items() if life.seen}
        stuff = {track.id for track in tracks if track.is_stuff}
        events = [e for e in step_events(step, names, last_seen) if not e.repeats or self._is_news(e, step, stuff)]
        for decision in step.decisions:
            life = self._life(decision.track_id)
            if not life.seen or life.seen[-1] != step.frame_index:
                life.seen.append(step.frame_index)
        for event in events:
            self._life(event.track_id).events.append((step.frame_index, event.text))
        for track_id, region in _regions(step):
            self._keep_crop(track_id, frame.rgb, region)
        for gone, survivor in step.fused:
            self._join(gone, survivor)
        return events

    def _is_news(self, event: Event, step: StepResult, stuff: set[int]) -> bool:
        """Whether nothing was said of the track for a while; walls have parts in every frame."""
        told = self._life(event.track_id).events
        return event.track_id not in stuff and (not told or step.frame_index - told[-1][0] >= QUIET_FRAMES)

    def _life(self, track_id: int) -> Life:
        return self.lives.setdefault(track_id, Life())

    def _join(self, gone: int, survivor: int) -> None:
        lost, life = self.lives.pop(gone, Life()), self._life(survivor)
        life.seen = sorted({*life.seen, *lost.seen})
        life.events = sorted([*lost.events, *life.events], key=lambda event: event[0])
        if lost.crop_score > life.crop_score:
            life.crop, life.crop_score = lost.crop, lost.crop_score

    def _keep_crop(self, track_id: int, rgb: Uint8Array, region: Region) -> None:
        life, score = self._life(track_id), region.pixels * (1.0 if region.whole else 0.5)
        if score > 1.1 * life.crop_score:  # much the same view need not be cut out again
            life.crop, life.crop_score = _cut(rgb, region.box), score


def _regions(step: StepResult) -> Iterator[tuple[int, Region]]:
    for decision in step.decisions:
        if decision.detection < len(step.detections):
            region = step.detections[decision.detection].region
            if region is not None:
                yield decision.track_id, region


def _cut(rgb: Uint8Array, box: tuple[int, int, int, int]) -> Uint8Array:
    """A part of an image (H, W, 3) with some of what is round it, no edge longer than CROP_PX."""
    x, y, width, height = box
    margin = int(MARGIN * max(width, height))
    part = rgb[max(y - margin, 0) : y + height + margin, max(x - margin, 0) : x + width + margin]
    scale = min(1.0, CROP_PX / max(part.shape[:2]))
    size = (max(1, round(scale * part.shape[1])), max(1, round(scale * part.shape[0])))
    return cv2.resize(part, size, interpolation=cv2.INTER_AREA)


def entity_names(names: Mapping[int, str | None]) -> dict[int, str]:
    """Entities of instances by id: "chair_12", "instance_3"; letters, digits and underscores."""
    plain = {i: "".join(c if c.isalnum() else "_" for c in name or "instance") for i, name in names.items()}
    return {i: f"{name}_{i}" for i, name in plain.items()}
