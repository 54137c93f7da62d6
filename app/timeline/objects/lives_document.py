"""The lives of all instances as one text: those of one name side by side, as the question is why there are two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from app.timeline.objects.near_namesakes import near_namesakes
from razer.map_object import MapObject
from razer.tracking.track import Track

INTRODUCTION = """Each detection is given to the track that costs least: `cost = w_v (1 - overlap) + w_s unlikeness`.
One that costs more than the gate is a new instance. So look where the second one *appears*, and why it was not the
first."""
PAIRS_FIRST = "**Two of one name in one place**, so perhaps one thing that was mapped twice; their lives come first:"
MAX_PAIRS = 6  # that are listed


def item_label(item: MapObject | Track) -> str:
    """ "chair #12", or "#12" where there is no name."""
    return f"{item.class_name or ''} #{item.id}".lstrip()


def pair_verdict(items: Sequence[MapObject]) -> list[str]:
    """Markdown: a line that names the pairs that may be one thing; none where there is no such pair."""
    pairs = [f"{item_label(a)} and #{b.id}" for a, b in near_namesakes(items)]
    if not pairs:
        return []
    more = f" and {len(pairs) - MAX_PAIRS} more" if len(pairs) > MAX_PAIRS else ""
    return [f"**Perhaps mapped twice: {', '.join(pairs[:MAX_PAIRS])}{more}**; *Objects* tells why"]


def lives_document(items: Sequence[MapObject], stories: Mapping[int, Sequence[tuple[int, str]]]) -> str:
    """Markdown: a section for each instance, first pairs that may be one thing, then things before surfaces, sorted by
    name and number.

    Args:
        items: the instances.
        stories: what happened to each, by id, with the frame.
    """
    pairs = near_namesakes(items)
    rank = {item.id: 0 for item in items}
    for place, pair in enumerate(pairs, start=-len(pairs)):
        for item in pair:
            rank[item.id] = min(rank[item.id], place)
    ordered = sorted(
        items, key=lambda item: (rank[item.id], item.is_stuff, item.class_name is None, item.class_name or "", item.id)
    )
    reasons = [f"- **{item_label(a)} and #{b.id}**{_birth(b, stories.get(b.id, ()))}" for a, b in pairs[:MAX_PAIRS]]
    opening = [PAIRS_FIRST, "\n".join(reasons)] if pairs else []
    sections = [_section(item, items, stories.get(item.id, ())) for item in ordered]
    return "\n\n".join([*opening, INTRODUCTION, *sections])


def _birth(item: MapObject, story: Sequence[tuple[int, str]]) -> str:
    """Why it was a new instance, where that is known."""
    return next((f": frame {frame}: {text}" for frame, text in story if f"#{item.id} appears" in text), "")


def _section(item: MapObject, items: Sequence[MapObject], story: Sequence[tuple[int, str]]) -> str:
    lines = [f"- frame {frame}: {text}" for frame, text in story] or ["- nothing is known of its life"]
    seen = (
        f"seen {item.observations} times, frames {item.first_frame} to {item.last_frame}, confidence {item.score:.2f}"
    )
    return "\n".join([f"### {item_label(item)}", f"{seen}{_nearest(item, items)}\n", *lines])


def _nearest(item: MapObject, items: Sequence[MapObject]) -> str:
    """The nearest other instance of the same name."""
    alike = [other for other in items if other.class_name == item.class_name and other.id != item.id]
    if not alike or item.class_name is None:
        return ""
    gap_m, other = min(
        ((float(np.linalg.norm(o.box.center - item.box.center)), o) for o in alike), key=lambda pair: pair[0]
    )
    return f"; the nearest other {item.class_name} is #{other.id}, {gap_m:.2f} m away"
