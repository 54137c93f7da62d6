"""What a query found, for programs and for people."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from app.console.streams import result_console
from app.query.view_crops import BestFrames
from razer.map_object import Answer, Hit
from razer.storage.instances_json import box_entry


def answer_json(query: str, answer: Answer, frames: BestFrames | None) -> dict[str, Any]:
    """The JSON of an answer: query, found, threshold and hits, which is empty where nothing was found."""
    hits = [_told(hit, frames) for hit in answer.hits]
    return {"query": query, "found": answer.found, "threshold": answer.threshold, "hits": hits}


def _told(hit: Hit, frames: BestFrames | None) -> dict[str, Any]:
    """One hit: centre and extent in metres, rotation world from box, the frames that show it best."""
    return {
        "id": hit.object.id,
        "score": round(hit.score, 4),
        "class": hit.class_guess,
        **box_entry(hit.object.box),
        "best_frames": frames.of(hit.object) if frames else [],
    }


def print_answer(result: dict[str, Any]) -> None:
    """A table of the hits, or that there are none."""
    console = result_console()
    if not result["found"]:
        console.print(f"not in this map: {result['query']}", soft_wrap=True)
        return
    table = Table()
    table.add_column("id", justify="right")
    table.add_column("score", justify="right")
    table.add_column("class")
    for name in ("centre, m", "size, m", "best seen in frames"):
        table.add_column(name, justify="right")
    for hit in result["hits"]:
        table.add_row(*_row(hit))
    console.print(table)
    crops = [frame["crop"] for hit in result["hits"] for frame in hit["best_frames"] if frame["crop"]]
    if crops:
        console.print(f"crops: {crops[0].rpartition('/')[0]}", soft_wrap=True)


def _row(hit: dict[str, Any]) -> tuple[str, ...]:
    centre = " ".join(f"{value:.2f}" for value in hit["center"])
    size = " x ".join(f"{value:.2f}" for value in sorted(hit["extent"], reverse=True))
    frames = ", ".join(str(frame["frame"]) for frame in hit["best_frames"])
    return str(hit["id"]), f"{hit['score']:.2f}", hit["class"] or "-", centre, size, frames
