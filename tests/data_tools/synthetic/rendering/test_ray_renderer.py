"""Ray casting and textures, against rays cast one by one."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.rendering.procedural_textures import PAINTERS, SIZE
from data_tools.synthetic.rendering.ray_renderer import RayRenderer, scene_of
from data_tools.synthetic.rendering.texture_atlas import LEVELS, paint_atlas
from data_tools.synthetic.scenes.living_room import living_room
from data_tools.synthetic.shapes.solids import box
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.frame import Intrinsics
from razer.geometry import back_project, transform_points

GREY = tinted("plaster", (200.0, 200.0, 200.0))


def test_textures_tile_and_their_small_copies_wrap() -> None:
    atlas = paint_atlas(3)
    for name in PAINTERS:
        for level in range(LEVELS):
            size, left, top = SIZE >> level, atlas.left[name], int(atlas.top[level])
            framed = atlas.image[top - 1 : top + size + 1, left - 1 : left + size + 1]
            assert np.array_equal(framed[:, 0], framed[:, -2])
            assert np.array_equal(framed[:, -1], framed[:, 1])
            assert np.array_equal(framed[0], framed[-2])
            assert framed.std() > 3 if level < 3 else True


def test_pixels_equal_rays_cast_one_by_one() -> None:
    room = SyntheticRoom(1, n_frames=30, width=320, height=240)
    things = living_room(1).things
    scene = scene_of(things)
    owner = np.concatenate([np.full(2 * len(s.quads), n) for n, t in things.items() for s in t.solids])
    # Each solid of a thing is a part of it.
    part = np.concatenate([np.full(2 * len(s.quads), n) for t in things.values() for n, s in enumerate(t.solids, 1)])
    for index in (0, 11, 22):
        frame = room[index]
        u, v = np.meshgrid(np.arange(320.0), np.arange(240.0))
        points = transform_points(frame.pose, back_project(u, v, np.ones_like(u), frame.intrinsics.matrix))
        center = np.broadcast_to(frame.pose[:3, 3], points.shape)
        rays = np.concatenate([center, points - center], axis=2).astype(np.float32)
        hits = scene.cast_rays(o3d.core.Tensor(rays))
        same = owner[hits["primitive_ids"].numpy()] == frame.instance_ids
        assert same.mean() > 0.9995
        assert (part[hits["primitive_ids"].numpy()] == frame.part_ids).mean() > 0.999
        assert len(np.unique(frame.part_ids)) > 2
        difference = np.abs(hits["t_hit"].numpy() - frame.depth)[same]
        # Where two faces of one thing meet, either may be seen; elsewhere the depths agree.
        assert (difference < 1e-3).mean() > 0.9995
        assert np.median(difference) < 1e-5


def test_odd_image_sizes_are_rendered_whole() -> None:
    things = {1: Thing("box", (box((-1, -1, 2), (1, 1, 3), GREY),))}
    for width, height in ((7, 5), (8, 5), (7, 6)):
        camera = Intrinsics(width, height, 50.0, 50.0, (width - 1) / 2, (height - 1) / 2)
        rgb, depth, ids, _ = RayRenderer(things, camera).render(np.eye(4))
        assert (ids == 1).all()
        np.testing.assert_allclose(depth, 2, atol=1e-6)
        assert (rgb > 0).any()


def test_what_no_ray_hits_is_empty() -> None:
    things = {3: Thing("box", (box((-0.1, -0.1, 2), (0.1, 0.1, 3), GREY),))}
    rgb, depth, ids, _ = RayRenderer(things, Intrinsics(40, 40, 20.0, 20.0, 19.5, 19.5)).render(np.eye(4))
    assert ids[0, 0] == depth[0, 0] == rgb[0, 0].sum() == 0
    assert ids[20, 20] == 3
    assert depth[20, 20] == pytest.approx(2)
