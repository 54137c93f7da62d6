"""instances.json: the instances of a map with their boxes, written and read."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float64Array, FloatArray
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.detection.best_views import BestView, Region
from razer.files import read_json
from razer.map_object import MapObject

FORMAT = 1
_BOX_SHAPES = {"center": (3,), "extent": (3,), "rotation": (3, 3)}
_MAX_NUMBER = 1e7  # metres: what is farther is no place
_MAX_ID = 2**24 - 1  # tables of colours have a row for each id up to the largest


def write_instances_json(
    path: Path,
    objects: Sequence[MapObject],
    up: Float64Array | None = None,
    stamps: Mapping[int, float] | None = None,
    parts: Sequence[MapObject] = (),
) -> None:
    """Write all instances with their boxes, and their parts, if there are any.

    Args:
        path: the file.
        objects: the instances, by id.
        up: the world's upward direction (3,), where it is known.
        stamps: seconds of frames by their index; others keep the stamp that their view has.
        parts: of the instances, by id.
    """
    header = {"format": FORMAT, "frame": "world, metres, right-handed", "up": None if up is None else _rounded(up)}
    content = {**header, "instances": [_instance_entry(o, stamps or {}) for o in objects]}
    if parts:
        content["parts"] = [_instance_entry(part, stamps or {}) for part in parts]
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def read_instances_json(path: Path) -> tuple[tuple[MapObject, ...], Float64Array | None]:
    """The instances, without embeddings and vertices, and the upward direction (3,) where it is known; raises one of
    MALFORMED for a file that is none."""
    content = read_json(path)
    if content["format"] != FORMAT:
        raise ValueError(f"format {content['format']}, this version reads {FORMAT}")
    up = content.get("up")
    objects = tuple(_object(entry) for entry in content["instances"])
    return objects, None if up is None else _unit(_numbers(up, (3,)))


def read_parts_json(path: Path) -> tuple[MapObject, ...]:
    """The parts of the instances in the same file, which has none if it is of an older map; raises as above."""
    content = read_json(path)
    return tuple(_object(entry) for entry in content.get("parts", ()))


def _numbers(value: Any, shape: tuple[int, ...]) -> Float64Array:
    array = np.array(value, np.float64)
    if array.shape != shape or not (np.abs(array) < _MAX_NUMBER).all():
        raise ValueError(f"{value} is not {' x '.join(map(str, shape))} finite numbers")
    return array


def _id(value: Any) -> int:
    if not 0 <= (number := int(value)) <= _MAX_ID:
        raise ValueError(f"{value} is no id of an instance: they are 0 to {_MAX_ID}")
    return number


def _unit(vector: Float64Array) -> Float64Array:
    if not 0.5 < np.linalg.norm(vector) < 2:
        raise ValueError(f"{vector.tolist()} is no direction")
    return vector


def _object(entry: Mapping[str, Any]) -> MapObject:
    if not isinstance(entry["class"], str | None):
        raise ValueError(f"the class of instance {entry['id']} is no text")
    center, extent, rotation = (_numbers(entry[part], shape) for part, shape in _BOX_SHAPES.items())
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3) or (extent < 0).any():
        raise ValueError(f"the box of instance {entry['id']} is none")
    return MapObject(
        id=_id(entry["id"]),
        class_name=entry["class"],
        score=float(entry["score"]),
        box=OrientedBox(center, rotation, extent),
        n_voxels=int(entry["n_voxels"]),
        n_vertices=int(entry["n_vertices"]),
        observations=int(entry["observations"]),
        first_frame=int(entry["first_frame"]),
        last_frame=int(entry["last_frame"]),
        embeddings=np.zeros((0, 0), np.float32),
        weights=np.zeros(0),
        views=tuple(_view(view) for view in entry.get("best_views", ())),
        is_stuff=bool(entry.get("stuff", False)),
        class_votes=tuple(_vote(vote) for vote in entry.get("class_votes", ())),
        part_of=None if entry.get("part_of") is None else _id(entry["part_of"]),
        is_edited=bool(entry.get("edited", False)),
        is_named_by_hand=bool(entry.get("named_by_hand", False)),
    )


def _vote(entry: Mapping[str, Any]) -> ClassVote:
    frames, weight, score = int(entry["frames"]), float(entry["weight"]), float(entry["score"])
    if not isinstance(entry["class"], str) or frames < 1 or not 0 <= weight < np.inf or not abs(score) < np.inf:
        raise ValueError(f"{dict(entry)} is no vote for a class")
    return ClassVote(entry["class"], int(entry["sector"]), frames, weight, score)


def _view(entry: Mapping[str, Any]) -> BestView:
    x, y, width, height = (int(number) for number in entry["box"])
    region = Region((x, y, width, height), int(entry["pixels"]), bool(entry["whole"]))
    return BestView(int(entry["frame"]), region, entry["stamp"])


def _instance_entry(item: MapObject, stamps: Mapping[int, float]) -> dict[str, object]:
    return {
        "id": item.id,
        "class": item.class_name,
        **({"stuff": True} if item.is_stuff else {}),
        **({} if item.part_of is None else {"part_of": item.part_of}),
        **({"edited": True} if item.is_edited else {}),
        **({"named_by_hand": True} if item.is_named_by_hand else {}),
        "score": round(item.score, 4),
        **box_entry(item.box),
        "n_voxels": item.n_voxels,
        "n_vertices": item.n_vertices,
        "observations": item.observations,
        "first_frame": item.first_frame,
        "last_frame": item.last_frame,
        **({"class_votes": [_vote_entry(vote) for vote in item.class_votes]} if item.class_votes else {}),
        "best_views": [_view_entry(view, stamps.get(view.frame, view.stamp)) for view in item.views],
    }


def _vote_entry(vote: ClassVote) -> dict[str, object]:
    return {
        "class": vote.name,
        "sector": vote.sector,
        "frames": vote.frames,
        "weight": round(vote.weight, 4),
        "score": round(vote.score, 4),
    }


def _view_entry(view: BestView, stamp: float | None) -> dict[str, object]:
    region = view.region
    return {
        "frame": view.frame,
        "stamp": stamp,
        "box": list(region.box),
        "pixels": region.pixels,
        "whole": region.whole,
    }


def box_entry(box: OrientedBox) -> dict[str, object]:
    """A box in a JSON file: center and extent in metres, rotation world from box."""
    rotation = [_rounded(row, 8) for row in box.rotation]
    return {"center": _rounded(box.center), "extent": _rounded(box.extent), "rotation": rotation}


def _rounded(values: FloatArray, digits: int = 5) -> list[float]:
    return [round(float(v), digits) for v in values]
