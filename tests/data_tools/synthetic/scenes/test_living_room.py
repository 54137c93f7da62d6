"""The demo room: what stands where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.scenes.living_room import HEIGHT_M, LENGTH_M, WIDTH_M, living_room
from data_tools.synthetic.shapes.solids import quad_normals
from data_tools.synthetic.truth.tessellation import tessellate
from tests.support.solids import after_move, signed_volume

SHELL = {1: "floor", 2: "ceiling", 3: "wall", 4: "wall", 5: "wall", 6: "wall"}


@pytest.mark.parametrize("seed", range(4))
def test_every_solid_but_the_shell_is_right_side_out(seed: int) -> None:
    for number, thing in living_room(seed).things.items():
        if number not in SHELL:
            for solid in thing.solids:
                assert signed_volume(replace(solid, quads=solid.quads - solid.quads.mean(axis=(0, 1)))) > 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("moved", [False, True])
def test_nothing_stands_inside_another_thing(seed: int, moved: bool) -> None:
    layout = living_room(seed)
    things = after_move(layout) if moved else layout.things
    surface = tessellate(things, 0.04)
    inside_room = np.array([LENGTH_M / 2, WIDTH_M / 2, HEIGHT_M]) + 1e-6
    assert (np.abs(surface.vertices) <= inside_room).all()
    assert surface.vertices[:, 2].min() >= -1e-9
    for number, thing in things.items():
        if number in SHELL:
            continue
        for solid in thing.solids:
            low, high = solid.quads.min(axis=(0, 1)) + 0.003, solid.quads.max(axis=(0, 1)) - 0.003
            near = (surface.instances != number) & ((surface.vertices > low) & (surface.vertices < high)).all(axis=1)
            if near.any() and len(solid.quads) == 6:
                depth = np.einsum(
                    "vqk,qk->vq", surface.vertices[near][:, None] - solid.quads[:, 0], quad_normals(solid.quads)
                ).max(axis=1)
                assert depth.min() > -0.003, (thing.class_name, surface.instances[near][depth.argmin()])


@pytest.mark.parametrize("seed", range(3))
def test_everything_touches_what_carries_it(seed: int) -> None:
    things = living_room(seed).things
    for number, thing in things.items():
        if number in SHELL:
            continue
        others = scene_of({n: t for n, t in things.items() if n != number})
        points = tessellate({number: thing}, 0.05).vertices.astype(np.float32)
        distance = others.compute_distance(o3d.core.Tensor(points)).numpy()
        assert distance.min() < 0.001, thing.class_name


def test_the_room_has_six_equal_chairs_and_about_thirty_things() -> None:
    things = living_room(0).things
    names = [thing.class_name for thing in things.values()]
    assert {number: names[number - 1] for number in SHELL} == SHELL
    assert names.count("chair") == 6
    assert 25 <= len(names) <= 40
    chairs = [t for t in things.values() if t.class_name == "chair"]
    sizes = [np.linalg.norm(np.diff(np.concatenate([s.quads for s in c.solids]), axis=1), axis=2) for c in chairs]
    for size in sizes[1:]:
        np.testing.assert_allclose(size, sizes[0], atol=1e-9)
