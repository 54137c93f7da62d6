"""Answer of a search of a library as JSON and as a table."""

from __future__ import annotations

from typing import Any

from rich.table import Column, Table

from app.console.streams import result_console
from app.library.map_search import LibraryAnswer, LibraryHit
from app.query.answer import hit_json

FORMAT = 1


def answer_json(query: str, answer: LibraryAnswer, *, by_scene: bool = False) -> dict[str, Any]:
    """The JSON of an answer: query, found, threshold, how many instances were asked, and hits; by scene these again,
    grouped, the scene of the best hit first."""
    hits = [_hit_json(hit) for hit in answer.hits]
    result = {
        "format": FORMAT,
        "query": query,
        "found": answer.found,
        "threshold": round(answer.threshold, 6),
        "asked": answer.n_asked,
        "hits": hits,
    }
    return result | ({"scenes": _by_scene(hits)} if by_scene else {})


def _by_scene(hits: list[dict[str, Any]]) -> list[dict[str, Any]]:
    scenes = dict.fromkeys(hit["scene"] for hit in hits)
    grouped = [(scene, [hit for hit in hits if hit["scene"] == scene]) for scene in scenes]
    return [{"scene": scene, "score": own[0]["score"], "hits": own} for scene, own in grouped]


def _hit_json(found: LibraryHit) -> dict[str, Any]:
    return {"run": found.run, "scene": found.scene, **hit_json(found.hit)}


def print_answer(result: dict[str, Any]) -> None:
    """Print a table of the hits, or that there are none."""
    console = result_console()
    if not result["found"]:
        console.print(f"not in any of these maps: {result['query']}", soft_wrap=True)
        return
    table = Table("scene", Column("run", overflow="fold"), "id", "score", "class", "centre, m", "size, m")
    scenes = [each["hits"] for each in result.get("scenes", [{"hits": result["hits"]}])]
    for hits in scenes:
        for hit in hits:
            table.add_row(*_row(hit), end_section=hit is hits[-1])
    console.print(table)


def _row(hit: dict[str, Any]) -> tuple[str, ...]:
    centre = " ".join(f"{value:.2f}" for value in hit["center"])
    size = " x ".join(f"{value:.2f}" for value in sorted(hit["extent"], reverse=True))
    whole = "" if hit["part_of"] is None else f" of {hit['part_of']}"
    return hit["scene"], hit["run"], f"{hit['id']}{whole}", f"{hit['score']:.2f}", hit["class"] or "-", centre, size
