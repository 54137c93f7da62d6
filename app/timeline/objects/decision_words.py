"""Association decisions in words: what a detection became, and why not something else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from razer.tracking.step_result import Candidate, Decision, StepResult

RUNNERS_UP = 2
CLOSE_CALL = 0.1  # above the gate: a track that was nearly taken is worth a word
LONG_UNSEEN = 60  # frames after which it is news that a track is seen again


class Event(NamedTuple):
    """One line of the log; the track that it belongs to; whether much the same may be said of it frame after frame."""

    track_id: int
    text: str
    repeats: bool = False


def step_events(step: StepResult, names: Mapping[int, str], last_seen: Mapping[int, int]) -> Iterator[Event]:
    """What one frame changed, in sentences.

    Args:
        step: the frame.
        names: what tracks are called, by id.
        last_seen: the frame before this one in which each track was seen.
    """
    for decision in step.decisions:
        track_id, name = decision.track_id, called(decision.track_id, names)
        gap = step.frame_index - last_seen.get(track_id, step.frame_index)
        if decision.outcome == "born":
            yield Event(track_id, f"{name} appears: {_why_new(decision, names)}")
        elif decision.outcome == "joined":
            yield Event(track_id, f"a further part joins {name}{_reasons(decision, names)}", repeats=True)
        elif gap > LONG_UNSEEN:
            yield Event(track_id, f"{name} is seen again after {gap} frames{_reasons(decision, names)}")
        elif _was_close(decision):
            yield Event(track_id, f"seen as {name}{_reasons(decision, names)}", repeats=True)
    for gone, survivor in step.fused:
        same = f"{called(gone, names)} was the same thing as {called(survivor, names)}"
        yield Event(survivor, f"{same}, and is part of it now")
    for track_id in step.pruned:
        yield Event(track_id, f"{called(track_id, names)} is dropped: it was not seen again, or looked through")


def called(track_id: int, names: Mapping[int, str]) -> str:
    """A track's class, if it has one, and number: "chair #12"."""
    return f"{names.get(track_id, '')} #{track_id}".lstrip()


def _was_close(decision: Decision) -> bool:
    return any(c.cost <= decision.gate + CLOSE_CALL for c in decision.candidates if c.track_id != decision.track_id)


def _why_new(decision: Decision, names: Mapping[int, str]) -> str:
    nearest = min(decision.candidates, key=lambda c: c.cost, default=None)
    if nearest is None:
        return "no other one is in reach"
    return f"it is not {called(nearest.track_id, names)}, which {_why_not(nearest, decision)}"


def _reasons(decision: Decision, names: Mapping[int, str]) -> str:
    chosen = next((c for c in decision.candidates if c.track_id == decision.track_id), None)
    others = sorted((c for c in decision.candidates if c.track_id != decision.track_id), key=lambda c: c.cost)
    text = "" if chosen is None else f": {_overlap(chosen)}, cost {chosen.cost:.2f}"
    if not others:
        return text
    return f"{text}; runner-up {called(others[0].track_id, names)} {_why_not(others[0], decision)}"


def _why_not(candidate: Candidate, decision: Decision) -> str:
    """Geometric and semantic distance weigh about the same: the larger one is the reason."""
    if candidate.cost <= decision.gate:
        return f"({_overlap(candidate)}, cost {candidate.cost:.2f}) went to a detection that fits it better"
    reason = "is too far" if candidate.geometry >= candidate.semantic else "looks different"
    return f"{reason}: {_overlap(candidate)}, cost {candidate.cost:.2f} > gate {decision.gate:.2f}"


def _overlap(candidate: Candidate) -> str:
    return f"{100 * (1 - candidate.geometry):.0f} % overlap"


def decision_table(step: StepResult) -> str:
    """Markdown: for each detection its outcome, track, cost M, V and S (RAZER eq. 8), and the runners-up."""
    if not step.decisions:
        return f"**Frame {step.frame_index}**: no detections"
    gate = step.decisions[0].gate
    lines = [
        f"**Frame {step.frame_index}**: {len(step.decisions)} detections, gate {gate:.2f}\n",
        "| det. | outcome | track | cost | V | S | others in reach |",
        "|--:|---|--:|--:|--:|--:|---|",
        *(_row(decision) for decision in step.decisions),
    ]
    return "\n".join(lines)


def _row(decision: Decision) -> str:
    chosen = [c for c in decision.candidates if c.track_id == decision.track_id]
    others = sorted((c for c in decision.candidates if c.track_id != decision.track_id), key=lambda c: c.cost)
    figures = " | ".join(_figures(c) for c in chosen[:1]) or " |  | "
    rest = ", ".join(f"#{c.track_id} {c.cost:.2f}" for c in others[:RUNNERS_UP])
    more = f" +{len(others) - RUNNERS_UP}" if len(others) > RUNNERS_UP else ""
    return f"| {decision.detection} | {decision.outcome} | #{decision.track_id} | {figures} | {rest}{more} |"


def _figures(candidate: Candidate) -> str:
    return f"{candidate.cost:.2f} | {candidate.geometry:.2f} | {candidate.semantic:.2f}"
