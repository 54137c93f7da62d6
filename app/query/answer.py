"""Answer of a query as JSON and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table

from app.console.streams import result_console
from app.query.view_crops import ViewCrops
from razer.map_object import Answer, Hit
from razer.storage.instances_json import box_entry


def answer_json(query: str, answer: Answer, crops: ViewCrops | None) -> dict[str, Any]:
    """The JSON of an answer: query, found, threshold and hits, which are empty if no instance matches."""
    hits = [hit_json(hit) | {"best_frames": crops.of(hit.object) if crops else []} for hit in answer.hits]
    return {"query": query, "found": answer.found, "threshold": answer.threshold, "hits": hits}


def hit_json(hit: Hit) -> dict[str, Any]:
    """One hit: the name and the kind it was found by where several names were meant, centre and extent in metres,
    rotation world from box."""
    return {
        "id": hit.object.id,
        "part_of": hit.object.part_of,
        "score": round(hit.score, 4),
        "class": hit.class_guess,
        "through": hit.through,
        "kind": hit.kind,
        "runner_up": hit.runner_up and hit.runner_up[0],
        "runner_up_score": hit.runner_up and round(hit.runner_up[1], 4),
        **box_entry(hit.object.box),
    }


def print_answer(result: dict[str, Any]) -> None:
    """Print a table of the hits, or that there are none."""
    console = result_console()
    if not result["found"]:
        console.print(f"not in this map: {result['query']}", soft_wrap=True)
        return
    console.print(_table(result["hits"]))
    crops = [frame["crop"] for hit in result["hits"] for frame in hit["best_frames"] if frame["crop"]]
    if crops:
        console.print(f"crops: {crops[0].rpartition('/')[0]}", soft_wrap=True)


def _table(hits: Sequence[dict[str, Any]]) -> Table:
    table = Table()
    table.add_column("id", justify="right")
    table.add_column("score", justify="right")
    table.add_column("class")
    if by_kind := any(hit["through"] for hit in hits):
        table.add_column("found as", no_wrap=True)
    for name in ("centre, m", "size, m", "best seen in frames"):
        table.add_column(name, justify="right")
    for hit in hits:
        table.add_row(*_row(hit, by_kind))
    return table


def _row(hit: dict[str, Any], by_kind: bool) -> tuple[str, ...]:
    centre = " ".join(f"{value:.2f}" for value in hit["center"])
    size = " x ".join(f"{value:.2f}" for value in sorted(hit["extent"], reverse=True))
    frames = ", ".join(str(frame["frame"]) for frame in hit["best_frames"])
    found_as = [", as ".join(filter(None, (hit["through"], hit["kind"])))] if by_kind else []
    runner_up = f", or {hit['runner_up']} {hit['runner_up_score']:.2f}" if hit["runner_up"] else ""
    whole = "" if hit["part_of"] is None else f" of {hit['part_of']}"
    named = f"{hit['class'] or '-'}{runner_up}"
    return f"{hit['id']}{whole}", f"{hit['score']:.2f}", named, *found_as, centre, size, frames
