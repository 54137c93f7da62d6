"""Segments of surfaces made by hand: what is one thing, what is two, and what is wall, floor or ceiling."""

from __future__ import annotations

import numpy as np
import pytest

from razer.config import SurfaceSegmentationSettings
from razer.mesh.labelled_mesh import LabelledMesh
from razer.surface_segmentation.segmentation import SurfaceSegments, segment_surface
from tests.support.voxel_surfaces import voxel_surface

N = 84  # cells of 2 cm: a corner of a room 1.7 m wide and high
FLOOR, WALL, FIRST, SECOND = 1, 2, 3, 4
BROWN, WHITE, BLUE, RED = (150, 120, 90), (220, 220, 215), (60, 60, 160), (160, 50, 40)
COLORS = {FLOOR: BROWN, WALL: WHITE, FIRST: BLUE, SECOND: RED}
UP = np.array([0.0, 0.0, 1.0])


def corner() -> np.ndarray:
    """A floor and two walls, as numbers of a grid."""
    solids = np.zeros((N, N, N), np.uint8)
    solids[:, :, 0] = FLOOR
    solids[:, -1], solids[0] = WALL, WALL
    return solids


def chair(solids: np.ndarray, number: int) -> None:
    """Seat, back and four legs."""
    solids[35:58, 35:58, 22:25] = number
    solids[35:58, 55:58, 22:46] = number
    for x in (35, 55):
        for y in (35, 55):
            solids[x : x + 3, y : y + 3, 1:23] = number


def segmented(mesh: LabelledMesh, up: np.ndarray = UP, **settings: float) -> SurfaceSegments:
    return segment_surface(mesh, up, SurfaceSegmentationSettings(**settings))


def overlap(segments: SurfaceSegments, mesh: LabelledMesh, number: int) -> tuple[int, float]:
    """The segment that a solid overlaps most, and their intersection over union."""
    is_solid = mesh.instances == number
    best = int(np.bincount(segments.labels[is_solid])[1:].argmax()) + 1
    union = (is_solid | (segments.labels == best)).sum()
    return best, (is_solid & (segments.labels == best)).sum() / union


def test_a_box_against_a_wall_is_one_thing_and_structure_has_names():
    solids = corner()
    solids[40:70, 50:83, 1:40] = FIRST
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    for number, name in ((FLOOR, "floor"), (WALL, "wall"), (FIRST, None)):
        segment, iou = overlap(segments, mesh, number)
        assert (segments.names[segment - 1], iou > 0.95) == (name, True), (number, iou)
    assert len(segments.scores) == len(segments.names) == segments.labels.max()
    assert segments.scores[overlap(segments, mesh, FIRST)[0] - 1] > 0.8


def test_a_chair_of_six_parts_is_one_thing():
    solids = corner()
    chair(solids, FIRST)
    mesh = voxel_surface(solids, COLORS)
    assert overlap(segmented(mesh), mesh, FIRST)[1] > 0.95


@pytest.mark.parametrize("height", [60, 35], ids=["coplanar fronts and tops", "of different height"])
def test_touching_things_of_different_colour_are_two(height):
    solids = corner()
    solids[20:45, 55:83, 1:60] = FIRST
    solids[45:70, 55:83, 1:height] = SECOND
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    (first, first_iou), (second, second_iou) = (overlap(segments, mesh, number) for number in (FIRST, SECOND))
    assert first != second
    assert min(first_iou, second_iou) > 0.9


def test_a_table_top_is_no_floor_and_a_cup_on_it_a_thing_of_its_own():
    solids = corner()
    solids[20:75, 25:70, 35:38] = FIRST
    for x in (20, 72):
        for y in (25, 67):
            solids[x : x + 3, y : y + 3, 1:36] = FIRST
    solids[44:49, 40:45, 38:44] = SECOND
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    (table, table_iou), (cup, cup_iou) = (overlap(segments, mesh, number) for number in (FIRST, SECOND))
    assert (segments.names[table - 1], segments.names[cup - 1], table != cup) == (None, None, True)
    assert table_iou > 0.95
    assert cup_iou > 0.7


def test_a_picture_on_a_wall_and_a_rug_on_a_floor_are_things():
    solids = corner()
    solids[30:60, -1, 40:70] = FIRST  # of the wall's own plane, another colour
    solids[20:70, 15:65, 0] = SECOND
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    for number in (FIRST, SECOND):
        segment, iou = overlap(segments, mesh, number)
        assert segments.names[segment - 1] is None
        assert iou > 0.85


def test_a_floor_of_two_rooms_of_different_colour_is_all_floor():
    """A rug is surrounded by floor; the floor of another room borders on it in the doorway only."""
    solids = np.zeros((2 * N, N, N), np.uint8)
    solids[:, :, 0] = FLOOR
    solids[N:, :, 0] = SECOND
    solids[:, -1] = WALL
    solids[N - 3 : N + 3, :60] = WALL  # between the rooms, but for a doorway
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    floors = np.isin(segments.labels, 1 + np.flatnonzero([name == "floor" for name in segments.names]))
    assert floors[np.isin(mesh.instances, (FLOOR, SECOND))].mean() > 0.9
    assert floors[mesh.instances == WALL].mean() < 0.02


def test_a_wardrobe_before_a_wall_is_no_wall():
    solids = corner()
    solids[25:55, 58:83, 1:80] = FIRST  # 1.6 m high: an upright plane of 0.95 square metres
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    segment, iou = overlap(segments, mesh, FIRST)
    assert segments.names[segment - 1] is None
    assert iou > 0.9


def test_a_ceiling_faces_down():
    solids = corner()
    solids[:, :, -1] = SECOND
    mesh = voxel_surface(solids, COLORS)
    segments = segmented(mesh)
    assert segments.names[overlap(segments, mesh, SECOND)[0] - 1] == "ceiling"
    assert segments.names[overlap(segments, mesh, FLOOR)[0] - 1] == "floor"


@pytest.mark.parametrize("up", [(0, 1, 0), (-1, 0, 0), (0.6, 0, 0.8)])
def test_structure_has_its_names_whatever_is_up(up):
    solids = corner()
    solids[40:70, 50:83, 1:40] = FIRST
    mesh = voxel_surface(solids, COLORS)
    turned_up = np.array(up, np.float64)
    first = np.cross(turned_up, [0.0, 0.0, 1.0] if abs(turned_up[2]) < 0.9 else [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    rotation = np.stack([first, np.cross(turned_up, first), turned_up], axis=1)  # takes z to up
    turned = LabelledMesh((mesh.vertices @ rotation.T).astype(np.float32), mesh.colors, mesh.instances, mesh.triangles)
    segments = segmented(turned, turned_up)
    for number, name in ((FLOOR, "floor"), (WALL, "wall"), (FIRST, None)):
        segment, iou = overlap(segments, mesh, number)
        assert (segments.names[segment - 1], iou > 0.95) == (name, True)


def test_the_order_of_vertices_and_triangles_changes_nothing():
    solids = corner()
    chair(solids, FIRST)
    solids[60:80, 50:83, 1:40] = SECOND
    mesh = voxel_surface(solids, COLORS)
    rng = np.random.default_rng(0)
    order, triangles = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.triangles))
    rank = np.argsort(order).astype(np.int32)
    shuffled = LabelledMesh(
        mesh.vertices[order], mesh.colors[order], mesh.instances[order], rank[mesh.triangles[triangles]]
    )
    one, other = segmented(mesh), segmented(shuffled)
    pairs = np.unique(np.stack([one.labels[order], other.labels]), axis=1)
    agree = [
        max(((one.labels[order] == a) & (other.labels == b)).sum() for a, b in pairs.T if a == k) for k in {*pairs[0]}
    ]
    assert one.names == other.names
    assert sum(agree) > 0.999 * len(mesh.vertices)


def test_a_score_below_the_least_and_a_speck_are_nobodys():
    solids = corner()
    solids[40:70, 50:83, 1:40] = FIRST
    solids[10:13, 10:13, 30:33] = SECOND  # 6 cm, in the air: 0.022 square metres
    mesh = voxel_surface(solids, COLORS)
    assert (segmented(mesh, min_area_m2=0.03).labels[mesh.instances == SECOND] == 0).all()
    assert (segmented(mesh, min_area_m2=0.01, min_score=0.0).labels[mesh.instances == SECOND] > 0).all()
    assert {*segmented(mesh, min_score=1.0).names} == {"wall", "floor"}


def test_no_surface_has_no_segments():
    none = np.zeros((0, 3), np.int32)
    empty = LabelledMesh(none.astype(np.float32), none.astype(np.uint8), none[:, 0], none)
    assert segmented(empty).names == ()
