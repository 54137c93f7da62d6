"""The furniture catalogue: names of the vocabulary, plausible sizes, closed surfaces that face outwards."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.objects.catalogue import PIECES
from data_tools.synthetic.rendering.procedural_textures import PAINTERS
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.solids import Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from razer.vocabulary import vocabulary

GREY = tinted("smooth", (200.0, 200.0, 200.0))
SEEDS = range(3)
# The largest extent in metres that a piece of the class has in a home or an office: at least, at most.
LARGEST_M = """
0.03 0.2: mouse, cup, alarm clock, toilet paper, candle
0.09 0.4: bowl, plate, bottle, water bottle, ball, tissue box, telephone, headphones, paper, book, toaster
0.15 0.6: coffee kettle, coffee maker, paper towel roll, keyboard, laptop, potted plant, tray, clothes, clock, purse
0.25 0.8: box, pillow, cushion, blanket, stuffed animal, bag, paper bag, backpack, bucket, basket, dish rack, towel
0.26 0.85: computer tower, printer, speaker, microwave, monitor, storage bin, crate, trash can, oven, stool
0.3 1.0: end table, nightstand, ottoman, mini fridge, laundry basket, fire extinguisher, toilet, chair
0.5 1.3: sink, office chair, armchair, stove, dishwasher, washing machine, clothes dryer, suitcase, guitar, cart
0.15 0.45: sign
0.4 1.8: picture, poster, mirror, range hood, recycling bin, tv, fan, radiator, blinds, plant, tv stand
0.35 2.0: ladder, lamp, bench, table, coffee table, desk, cabinet, dresser, file cabinet, kitchen cabinet, mat
0.4 2.5: bulletin board, couch, dining table, counter, bathtub, mattress, whiteboard, blackboard, window, refrigerator
1.2 2.8: bed, wardrobe, bookshelf, shelf, door, doorframe, shower, shower curtain, curtain, column, coat rack
"""
RANGE_OF = {
    name: tuple(map(float, span.split()))
    for span, names in (line.split(": ") for line in LARGEST_M.strip().splitlines())
    for name in names.split(", ")
}
# What hangs on or leans to a wall: nothing of it is behind the wall plane y = 0.
ON_WALLS = frozenset(
    {
        "picture",
        "poster",
        "mirror",
        "whiteboard",
        "blackboard",
        "sign",
        "bulletin board",
        "window",
        "door",
        "doorframe",
        "blinds",
        "clock",
        "radiator",
        "curtain",
        "shower curtain",
        "towel",
        "range hood",
    }
)


def made(name: str, seed: int) -> Thing:
    return PIECES[name](np.random.default_rng(seed))


def all_quads(thing: Thing) -> np.ndarray:
    return np.concatenate([solid.quads for solid in thing.solids])


def test_there_are_more_than_forty_classes_and_each_is_in_the_vocabulary() -> None:
    assert len(PIECES) >= 44
    names = vocabulary("scannet200").by_name
    assert [name for name in PIECES if name not in names or names[name].nyu40 <= 0] == []
    assert set(PIECES) > ON_WALLS
    assert set(RANGE_OF) == set(PIECES)


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_carries_its_name_and_known_textures(name: str) -> None:
    thing = made(name, 0)
    assert thing.class_name == name
    assert {solid.material.texture for solid in thing.solids} <= set(PAINTERS)
    for solid in thing.solids:
        assert all(0 <= c <= 255 for c in (*solid.material.dark, *solid.material.light))


@pytest.mark.parametrize("name", PIECES)
def test_it_stands_on_the_floor_round_the_origin_or_hangs_before_the_wall(name: str) -> None:
    for seed in SEEDS:
        low, high = made(name, seed).bounds
        assert abs(low[2]) < 1e-3
        if name in ON_WALLS:
            assert abs(low[1]) < 0.035
            assert low[1] > -1e-9
        else:
            assert low[1] < 0 < high[1]
        assert low[0] < 0 < high[0]
        assert abs(low[0] + high[0]) < 0.35 * (high[0] - low[0])


@pytest.mark.parametrize("name", PIECES)
def test_its_largest_extent_is_that_of_its_class(name: str) -> None:
    least, most = RANGE_OF[name]
    for seed in range(8):
        low, high = made(name, seed).bounds
        assert least <= (high - low).max() <= most


@pytest.mark.parametrize("name", PIECES)
def test_equal_seeds_give_equal_pieces_and_others_differ(name: str) -> None:
    one, same, other = (made(name, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(all_quads(one), all_quads(same))
    assert [s.material for s in one.solids] == [s.material for s in same.solids]
    assert np.abs(np.subtract(one.bounds, other.bounds)).max() > 1e-4
    assert one.solids[0].material != other.solids[0].material or one.solids[-1].material != other.solids[-1].material


@pytest.mark.parametrize("name", PIECES)
def test_quads_are_planar_few_and_none_is_degenerate(name: str) -> None:
    for seed in SEEDS:
        quads = all_quads(made(name, seed))
        assert len(quads) <= 200
        normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
        assert np.linalg.norm(normals, axis=1).min() > 1e-7
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        assert np.abs(np.einsum("qik,qk->qi", quads - quads[:, :1], normals)).max() < 1e-6


@pytest.mark.parametrize("name", PIECES)
def test_every_solid_is_closed_and_right_side_out(name: str) -> None:
    for seed in SEEDS:
        for solid in made(name, seed).solids:
            a, b, c, d = np.moveaxis(solid.quads - solid.quads.mean(axis=(0, 1)), 1, 0)
            # The area vectors of a closed surface cancel.
            area = (np.cross(b - a, c - a) + np.cross(c - a, d - a)) / 2
            assert np.abs(area.sum(axis=0)).max() < 1e-9
            assert np.einsum("qk,qk->", a, np.cross(b, c)) + np.einsum("qk,qk->", a, np.cross(c, d)) > 0


def level(thing: Thing, x: float, y: float) -> float:
    """The height of what lies uppermost at a place."""
    ray = np.array([[x, y, 5, 0, 0, -1]], np.float32)
    return 5 - float(scene_of({1: thing}).cast_rays(o3d.core.Tensor(ray))["t_hit"].numpy()[0])


@pytest.mark.parametrize("seed", range(6))
def test_a_chair_stands_on_four_legs_with_a_seat_to_sit_on_and_a_back_behind_it(seed: int) -> None:
    chair = made("chair", seed)
    points = all_quads(chair).reshape(-1, 3)
    feet = points[points[:, 2] < 1e-6]
    assert {(bool(x > 0), bool(y > 0)) for x, y, _ in feet} == {(a, b) for a in (True, False) for b in (True, False)}
    seat = level(chair, 0, 0.05)
    assert 0.42 < seat < 0.53
    above = points[points[:, 2] > seat + 0.15]
    assert above[:, 1].max() < -0.1
    assert above[:, 2].max() - seat > 0.3


@pytest.mark.parametrize("seed", range(6))
def test_a_beds_duvet_is_level_higher_than_the_mattress_at_its_head_and_turned_back_between(seed: int) -> None:
    bed = made("bed", seed)
    duvet, fold, sheet = (level(bed, 0, y) for y in (0.5, -0.28, -0.75))
    assert level(bed, 0.2, 0.7) == pytest.approx(duvet, abs=1e-4)
    assert sheet + 0.02 < duvet < fold < sheet + 0.1
    low, high = bed.bounds
    assert high[2] == pytest.approx(level(bed, 0, float(low[1]) + 0.02), abs=1e-4)  # the headboard is the highest


@pytest.mark.parametrize("seed", range(12))
def test_a_book_is_one_book_closed_or_open(seed: int) -> None:
    book = made("book", seed)
    high = book.bounds[1]
    assert high[2] < 0.05
    pages = [solid for solid in book.solids if solid.material.texture == "print"]
    assert len(pages) in (0, 2)
    if pages:
        assert level(book, 0.06, 0) > level(book, 0, 0) + 0.002  # pages swell on both sides of the fold
        assert level(book, 0.06, 0) == pytest.approx(level(book, -0.06, 0), abs=4e-3)


def rays_from_outside(thing: Thing, count: int, rng: np.random.Generator) -> np.ndarray:
    """Rays (count, 6) from all sides, above the floor and before the wall, to points in the thing's box."""
    low, high = thing.bounds
    radius = 1.2 * np.linalg.norm(high - low)
    azimuth = rng.uniform(0, np.pi if thing.class_name in ON_WALLS else 2 * np.pi, count)
    height = rng.uniform(0.01, high[2] + radius, count)
    aside = (low + high)[:2] / 2 + radius * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    origins = np.column_stack([aside, height])
    towards = rng.uniform(low, high, (count, 3)) - origins
    return np.hstack([origins, towards / np.linalg.norm(towards, axis=1, keepdims=True)]).astype(np.float32)


def hits(thing: Thing, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of every hit: its ray, distance, solid and the cosine between ray and outward normal."""
    found = scene_of({1: thing}).list_intersections(o3d.core.Tensor(rays))
    ray, distance, triangle = (found[key].numpy() for key in ("ray_ids", "t_hit", "primitive_ids"))
    quads = all_quads(thing)
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    solid = np.repeat(np.arange(len(thing.solids)), [len(s.quads) for s in thing.solids])
    quad = triangle // 2
    return ray.astype(int), distance, solid[quad], np.einsum("hk,hk->h", rays[ray.astype(int), 3:], normals[quad])


def looked_at(thing: Thing, count: int = 1500) -> tuple[float, float]:
    """The share of rays that see an inner side first, and of those whose first hit lies on two solids at once that
    both face the viewer, so that their colours would flicker."""
    ray, distance, solid, cosine = hits(thing, rays_from_outside(thing, count, np.random.default_rng(5)))
    nearest = np.full(count, np.inf)
    np.minimum.at(nearest, ray, distance)
    inner = len(np.unique(ray[(distance <= nearest[ray]) & (cosine > 1e-3)]))
    near = (distance < nearest[ray] + 2e-5) & (cosine < -0.02)
    pairs = np.unique(np.stack([ray[near], solid[near]]), axis=1)
    return inner / count, float((np.bincount(pairs[0], minlength=count) > 1).mean())


@pytest.mark.parametrize("name", PIECES)
def test_from_outside_one_sees_outer_sides_without_flicker(name: str) -> None:
    for seed in SEEDS:
        inner, flickering = looked_at(made(name, seed))
        assert inner <= 0.002
        assert flickering <= 0.002


def test_the_checks_notice_an_inverted_solid_and_overlapping_faces() -> None:
    whole = block(0, 0, 0, (1, 1, 1), GREY)
    inverted = Solid(whole.quads[:, ::-1].copy(), whole.uv[:, ::-1].copy(), GREY)
    level = block(0.5, 0, 0, (0.6, 0.5, 1), GREY)
    assert looked_at(Thing("box", (whole,))) == (0, 0)
    assert looked_at(Thing("box", (inverted,)))[0] > 0.9
    assert looked_at(Thing("box", (whole, level)))[1] > 0.01
