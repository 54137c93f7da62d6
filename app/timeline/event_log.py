"""Event log of one mapped frame: a line for each event, and a table of the association decisions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

from razer.tracking.step_result import Candidate, Decision, StepResult

RUNNERS_UP = 2


class Event(NamedTuple):
    """One line of the log."""

    level: Literal["DEBUG", "INFO", "WARN"]
    text: str


def step_events(step: StepResult) -> Iterator[Event]:
    """The events of one frame: born, fused and pruned tracks singly, matched and joined ones in one line."""
    for decision in step.decisions:
        if decision.outcome == "born":
            yield Event("INFO", f"born #{decision.track_id}: {_why_new(decision)}")
    for gone, survivor in step.fused:
        yield Event("INFO", f"fused #{gone} into #{survivor}")
    for track_id in step.pruned:
        yield Event("INFO", f"pruned #{track_id}")
    for outcome in ("matched", "joined"):
        ids = sorted({d.track_id for d in step.decisions if d.outcome == outcome})
        if ids:
            yield Event("DEBUG", f"{outcome} {' '.join(f'#{i}' for i in ids)}")


def _why_new(decision: Decision) -> str:
    nearest = min(decision.candidates, key=lambda c: c.cost, default=None)
    if nearest is None:
        return "no track in reach"
    if nearest.cost > decision.gate:
        return f"nearest #{nearest.track_id} costs {nearest.cost:.2f}, gate {decision.gate:.2f}"
    return f"#{nearest.track_id} at {nearest.cost:.2f} went to another detection"


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
