"""The finished instances on the timeline: an entity each, with box, surface, facts, life, and how often it was seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from scipy.spatial import cKDTree

from app.render.palette import instance_colors
from app.render.viewpoint import Viewpoint
from app.timeline import entities
from app.timeline.images import jpeg
from app.timeline.objects.clear_labels import clear_labels
from app.timeline.objects.lives_document import item_label, lives_document
from app.timeline.objects.object_history import CROP_PX, Life, entity_names
from app.timeline.recording.rerun_log import Color, RerunLog
from razer.arrays import Float32Array, Int32Array, Uint8Array
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap

MAX_POINTS = 1500  # of an instance
SAME_PLACE_M = 0.1  # surface of a track as last drawn, and of the finished map
CAPTION_LETTERS, CAPTION_FONT = 15, cv2.FONT_HERSHEY_SIMPLEX
MIN_SHARE = 0.2  # of an instance's surface, for a track to be told as part of it
MAX_LABELS = 20
VIEW_PX = 440  # height of the view of objects in a window of usual size
SHEET_MARGIN_PX = 14
CAPTION_PX, CAPTION_SCALE, SHEET_COLUMNS, SHEET_TILES = 18, 0.45, 12, 48  # as wide as the view that it fills


def log_objects(
    log: RerunLog,
    panoptic: PanopticMap,
    lives: Mapping[int, Life],
    drawn: tuple[Float32Array, Int32Array],
    eye: Viewpoint,
) -> None:
    """Log every instance of the finished map.

    Args:
        log: where to.
        panoptic: the finished map.
        lives: of the tracks, by id.
        drawn: points (N, 3) of the surface as last drawn, and the tracks (N,) that they belonged to.
        eye: where they are looked at from, at first.
    """
    names = entity_names({item.id: item.class_name for item in panoptic.objects})
    rows = _rows_by_instance(panoptic.mesh.instances)
    tiles: list[tuple[str, Color, Uint8Array]] = []
    stories: dict[int, list[tuple[int, str]]] = {}
    largest = sorted(panoptic.objects, key=lambda item: (item.is_stuff, -item.n_voxels))
    for item in largest:
        points = panoptic.mesh.vertices[rows.get(item.id, np.zeros(0, np.int64))]
        told = [(item.id, lives[item.id])] if item.id in lives else _lives_at(points, lives, drawn)
        red, green, blue = instance_colors(np.array([item.id]))[0].tolist()
        color, entity = (red, green, blue), f"{entities.OBJECTS}/{names[item.id]}"
        surface = points[:: len(points) // MAX_POINTS + 1]
        log.item(entity, item.box, surface, color, item_label(item))
        log.facts(entity, facts(item))
        stories[item.id] = _log_life(log, entity, names[item.id], item, told, color)
        crops = [life.crop for _, life in told if life.crop is not None]
        if crops:
            tiles.append((item_label(item), color, crops[0]))
    log_labels(log, entities.OBJECT_LABELS, [item for item in largest if not item.is_stuff], eye, VIEW_PX)
    log.document(entities.LIVES, lives_document(panoptic.objects, stories))
    if tiles:
        log.jpeg(entities.CROPS, jpeg(_contact_sheet(tiles[:SHEET_TILES]), 80))


def log_labels(log: RerunLog, entity: str, items: Sequence[MapObject], eye: Viewpoint, height_px: float) -> None:
    """Log names of the first of these that leave each other readable in a view so many pixels high, in the middles of
    their boxes."""
    if not items:
        return log.clear(entity, recursive=False)
    middles, texts = np.array([item.box.center for item in items]), [item_label(item) for item in items]
    rows = clear_labels(middles, texts, eye, height_px)[:MAX_LABELS]
    return log.labels(entity, middles[rows], [texts[row] for row in rows])


def facts(item: MapObject) -> dict[str, str | float]:
    """What is known of an instance, for the viewer's panel."""
    votes: dict[str, float] = {}
    for vote in item.class_votes:
        votes[vote.name] = votes.get(vote.name, 0.0) + vote.weight
    total = sum(votes.values()) or 1.0
    guesses = sorted(votes.items(), key=lambda pair: -pair[1])[:3]
    size = " x ".join(f"{edge:.2f}" for edge in sorted(item.box.extent, reverse=True))
    return {
        "class_guesses": ", ".join(f"{name} {100 * weight / total:.0f} %" for name, weight in guesses) or "no name",
        "confidence": round(item.score, 2),
        "size_m": size,
        "first_seen_frame": item.first_frame,
        "last_seen_frame": item.last_frame,
        "times_seen": item.observations,
    }


def _log_life(
    log: RerunLog, entity: str, name: str, item: MapObject, told: Sequence[tuple[int, Life]], color: Color
) -> list[tuple[int, str]]:
    """Log what happened to an instance, which is returned, and how often it was seen until when."""
    events = sorted(event for _, life in told for event in life.events)
    if told and [number for number, _ in told] != [item.id]:
        parts = ", ".join(f"#{number}" for number, _ in told)
        events.append((item.last_frame, f"the finished surface shows as one what was tracked as {parts}"))
    if events:
        log.texts(entity, [frame for frame, _ in events], [text for _, text in events])
    seen = sorted({frame for _, life in told for frame in life.seen})
    if seen:
        log.series(f"{entities.OBSERVATIONS}/{name}", [item_label(item)], [color])
        log.curve(f"{entities.OBSERVATIONS}/{name}", seen, list(range(1, len(seen) + 1)))
    return events


def _rows_by_instance(instances: Int32Array) -> dict[int, Int32Array]:
    order = np.argsort(instances, kind="stable")
    ids, first = np.unique(instances[order], return_index=True)
    # Where there is nothing, splitting it gives one empty part all the same.
    return dict(zip(ids.tolist(), np.split(order, first[1:]), strict=False))


def _lives_at(
    points: Float32Array, lives: Mapping[int, Life], drawn: tuple[Float32Array, Int32Array]
) -> list[tuple[int, Life]]:
    """The tracks whose surface lay where that of an instance is, that with the largest share first."""
    positions, tracks = drawn
    if not len(points) or not len(positions):
        return []
    distance, nearest = cKDTree(positions).query(points[:: len(points) // MAX_POINTS + 1])
    ids, counts = np.unique(tracks[nearest[distance < SAME_PLACE_M]], return_counts=True)
    shares = sorted(zip((-counts / max(counts.sum(), 1)).tolist(), ids.tolist(), strict=True))
    return [(number, lives[number]) for share, number in shares if number in lives and -share >= MIN_SHARE]


def _contact_sheet(tiles: Sequence[tuple[str, Color, Uint8Array]]) -> Uint8Array:
    """Pictures (h, w, 3) under their names, on white, framed in their colours."""
    cell = CROP_PX + CAPTION_PX + 6
    n_rows = -(-len(tiles) // SHEET_COLUMNS)
    sheet = np.full((n_rows * cell, SHEET_COLUMNS * (CROP_PX + 6), 3), 255, np.uint8)
    for number, (name, color, crop) in enumerate(tiles):
        row, column = divmod(number, SHEET_COLUMNS)
        y, x = row * cell + CAPTION_PX + 3, column * (CROP_PX + 6) + 3
        height, width = crop.shape[:2]
        sheet[y : y + height, x : x + width] = crop
        cv2.rectangle(sheet, (x - 2, y - 2), (x + width + 1, y + height + 1), color, 2)
        place = (x, y - 5)
        cv2.putText(sheet, name[:CAPTION_LETTERS], place, CAPTION_FONT, CAPTION_SCALE, (0, 0, 0), 1, cv2.LINE_AA)
    return np.pad(sheet, [(SHEET_MARGIN_PX,) * 2, (SHEET_MARGIN_PX,) * 2, (0, 0)], constant_values=255)
