"""Votes by boxes against a slow look at every voxel."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from razer.boxes.oriented_box import OrientedBox
from razer.detection.observed_surface import ObservedSurface
from razer.volume.box_voting import vote_in_boxes
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import CAMERA, COARSE, axis_box, contents, detection, frame_of, look

WALL = frame_of(np.full((120, 160), 2.01))
BOXES = {1: axis_box((0, 0, 2), (1.0, 0.6, 0.12)), 2: axis_box((0.4, 0, 2), (0.5, 0.4, 1.0))}


def mapped() -> tuple[VoxelMap, ObservedSurface]:
    voxels = VoxelMap(COARSE)
    surface = look(WALL)
    voxels.integrate(WALL, surface)
    voxels.admit(9)
    return voxels, surface


def slow_votes(voxels: VoxelMap, boxes: dict[int, OrientedBox]) -> Counter[tuple[int, int, int, int]]:
    """(x, y, z, id) of each vote that is due: in view, in the band of the wall at 2.01 m, in the box."""
    stored, due = contents(voxels), Counter()
    for block, weights in zip(stored["keys"].tolist(), stored["weight"][..., 0], strict=True):
        for place in np.flatnonzero(weights > 0).tolist():
            cell = np.array(block) * 16 + [place % 16, place // 16 % 16, place // 256]
            x, y, z = cell * 0.04
            u, v = CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy
            if -0.5 < u < 159.5 and -0.5 < v < 119.5 and abs(z - 2.01) <= 0.16:
                due.update((*cell.tolist(), i) for i, box in boxes.items() if box.contains(cell[None] * 0.04)[0])
    return due


def stored_votes(voxels: VoxelMap) -> Counter[tuple[int, int, int, int]]:
    stored, found = contents(voxels), Counter()
    for block, ids, counts in zip(stored["keys"].tolist(), stored["ids"], stored["counts"], strict=True):
        for place, slot in np.argwhere(counts > 0).tolist():
            cell = np.array(block) * 16 + [place % 16, place // 16 % 16, place // 256]
            found[*cell.tolist(), int(ids[place, slot])] += int(counts[place, slot])
    return found


def test_every_voxel_of_the_band_votes_for_each_box_it_lies_in() -> None:
    voxels, surface = mapped()
    seen = [replace(detection(box), pixels=np.arange(50, dtype=np.int32)) for box in BOXES.values()]
    image = vote_in_boxes(voxels, surface, seen, np.array([1, 2], np.int32), BOXES)
    due = slow_votes(voxels, BOXES)
    assert stored_votes(voxels) == due
    depths = {z for _, _, z, i in due if i == 2}
    assert len(depths) > 4, "the band, not the surface alone"
    assert {key[:3] for key in due if key[3] == 1} & {key[:3] for key in due if key[3] == 2}, "both vote in the overlap"
    assert image.shape == surface.depth.shape


def test_only_tracks_of_the_frame_are_voted_for_and_fused_ones_by_their_survivor() -> None:
    voxels, surface = mapped()
    box = BOXES[1]
    for track_id in (1, 3):
        vote_in_boxes(voxels, surface, [], np.zeros(0, np.int32), BOXES)
        vote_in_boxes(voxels, surface, [detection(box)], np.array([track_id], np.int32), {track_id: box})
    voxels.replace(3, 1)
    vote_in_boxes(voxels, surface, [detection(box)], np.array([1], np.int32), BOXES)
    votes = stored_votes(voxels)
    assert {key[3] for key in votes} == {1}
    assert set(votes.values()) == {3}
