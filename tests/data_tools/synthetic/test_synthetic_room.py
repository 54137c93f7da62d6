"""The synthetic room: its geometry, pictures, truth and the folder it is written to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from data_tools import open_sequence
from data_tools.synthetic.camera.hand_held import walk_round
from data_tools.synthetic.objects.furniture.simple_furniture import Thing, tinted
from data_tools.synthetic.rendering.procedural_textures import PAINTERS, SIZE
from data_tools.synthetic.rendering.ray_renderer import RayRenderer, scene_of
from data_tools.synthetic.rendering.texture_atlas import LEVELS, paint_atlas
from data_tools.synthetic.scenes.living_room import HEIGHT_M, LENGTH_M, WIDTH_M, living_room
from data_tools.synthetic.shapes.solids import Solid, box, lathe, quad_normals
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.truth.tessellation import tessellate
from data_tools.synthetic.truth.true_surface import ground_truth
from data_tools.synthetic.truth.visibility import TOLERANCE_M, CameraView, Vantage
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import read_truth, write_truth
from data_tools.writers.own_folder import write_folder
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.geometry import back_project, inverse, project, transform_points

GREY = tinted("plaster", (200.0, 200.0, 200.0))
SHELL = {1: "floor", 2: "ceiling", 3: "wall", 4: "wall", 5: "wall", 6: "wall"}


@pytest.fixture(scope="module")
def room() -> SyntheticRoom:
    return SyntheticRoom(0, n_frames=40, width=160, height=120)


@pytest.fixture(scope="module")
def truth(room: SyntheticRoom) -> GroundTruth:
    return room.truth(spacing_m=0.05)


def world_points(frame: Frame) -> np.ndarray:
    v, u = np.mgrid[: frame.intrinsics.height, : frame.intrinsics.width]
    return transform_points(frame.pose, back_project(u, v, frame.depth.astype(float), frame.intrinsics.matrix))


def signed_volume(solid: Solid) -> float:
    """A sixth of the triple products of all triangles: the volume if the quads close and face outwards."""
    a, b, c, d = np.moveaxis(solid.quads, 1, 0)
    return float((np.einsum("qk,qk->", a, np.cross(b, c)) + np.einsum("qk,qk->", a, np.cross(c, d))) / 6)


def test_boxes_and_lathes_enclose_their_volume_facing_outwards() -> None:
    assert signed_volume(box((1, 2, 3), (2, 4, 6), GREY)) == pytest.approx(6)
    cylinder = lathe([(0, 0), (0.5, 0), (0.5, 2), (0, 2)], GREY, at=(3, 1), sides=24)
    assert signed_volume(cylinder) == pytest.approx(2 * 0.5 * 24 * 0.25 * np.sin(2 * np.pi / 24))
    normals = quad_normals(cylinder.quads)
    outwards = cylinder.quads.mean(axis=1) - (3, 1, 1)
    assert (np.einsum("qk,qk->q", normals, outwards) > 0).all()


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
    things = layout.after_move().things if moved else layout.things
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


def test_depth_lies_on_the_planes_of_floor_ceiling_and_walls(room: SyntheticRoom) -> None:
    planes = {1: (2, 0.0), 2: (2, HEIGHT_M), 3: (1, -WIDTH_M / 2), 4: (0, LENGTH_M / 2), 5: (1, WIDTH_M / 2)}
    planes[6] = (0, -LENGTH_M / 2)
    checked = set()
    for index in range(0, 40, 3):
        frame = room[index]
        assert frame.instance_ids is not None
        points = world_points(frame)
        for number, (axis, value) in planes.items():
            on = frame.instance_ids == number
            checked |= {number} if on.any() else set()
            assert np.abs(points[on][:, axis] - value).max(initial=0) < 1e-4
    assert checked == set(planes)


def test_pixels_equal_rays_cast_one_by_one() -> None:
    room = SyntheticRoom(1, n_frames=30, width=320, height=240)
    things = living_room(1).things
    scene = scene_of(things)
    owner = np.concatenate([np.full(2 * len(s.quads), n) for n, t in things.items() for s in t.solids])
    for index in (0, 11, 22):
        frame = room[index]
        u, v = np.meshgrid(np.arange(320.0), np.arange(240.0))
        points = transform_points(frame.pose, back_project(u, v, np.ones_like(u), frame.intrinsics.matrix))
        center = np.broadcast_to(frame.pose[:3, 3], points.shape)
        rays = np.concatenate([center, points - center], axis=2).astype(np.float32)
        hits = scene.cast_rays(o3d.core.Tensor(rays))
        same = owner[hits["primitive_ids"].numpy()] == frame.instance_ids
        assert same.mean() > 0.9995
        difference = np.abs(hits["t_hit"].numpy() - frame.depth)[same]
        # Where two faces of one thing meet, either may be seen; elsewhere the depths agree.
        assert (difference < 1e-3).mean() > 0.9995
        assert np.median(difference) < 1e-5


def test_odd_image_sizes_are_rendered_whole() -> None:
    things = {1: Thing("box", (box((-1, -1, 2), (1, 1, 3), GREY),))}
    for width, height in ((7, 5), (8, 5), (7, 6)):
        camera = Intrinsics(width, height, 50.0, 50.0, (width - 1) / 2, (height - 1) / 2)
        rgb, depth, ids = RayRenderer(things, camera).render(np.eye(4))
        assert (ids == 1).all()
        np.testing.assert_allclose(depth, 2, atol=1e-6)
        assert (rgb > 0).any()


def test_what_no_ray_hits_is_empty() -> None:
    things = {3: Thing("box", (box((-0.1, -0.1, 2), (0.1, 0.1, 3), GREY),))}
    rgb, depth, ids = RayRenderer(things, Intrinsics(40, 40, 20.0, 20.0, 19.5, 19.5)).render(np.eye(4))
    assert ids[0, 0] == depth[0, 0] == rgb[0, 0].sum() == 0
    assert ids[20, 20] == 3
    assert depth[20, 20] == pytest.approx(2)


def test_a_texture_stays_on_its_surface(room: SyntheticRoom) -> None:
    """The colour of a wall point is the same from two places, up to blur and filtering."""
    rows = []
    for index in range(0, 40, 2):
        here, there = room[index], room[(index + 1) % 40]
        points = world_points(here)
        u, v, z = project(transform_points(inverse(there.pose), points), here.intrinsics.matrix)
        x, y = np.rint(np.nan_to_num(u, nan=-1)).astype(int), np.rint(np.nan_to_num(v, nan=-1)).astype(int)
        inside = (x >= 0) & (x < 160) & (y >= 0) & (y < 120) & (z > 0)
        x, y = x.clip(0, 159), y.clip(0, 119)
        agree = inside & (np.abs(there.depth[y, x] - z) < 0.01) & (there.instance_ids[y, x] == here.instance_ids)
        grey = here.rgb.mean(axis=2)[agree], there.rgb.mean(axis=2)[y, x][agree]
        rows.append(np.stack(grey))
    first, second = np.concatenate(rows, axis=1)
    assert len(first) > 50_000
    assert np.corrcoef(first, second)[0, 1] > 0.9


def test_frames_are_a_pure_function_of_the_arguments(room: SyntheticRoom) -> None:
    again = SyntheticRoom(0, n_frames=40, width=160, height=120)
    late, early = again[31], again[2]
    for one, other in ((room[2], early), (room[31], late)):
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.depth, other.depth)
        assert np.array_equal(one.instance_ids, other.instance_ids)
        assert np.array_equal(one.pose, other.pose)
    assert not np.array_equal(SyntheticRoom(1, n_frames=40, width=160, height=120)[2].rgb, early.rgb)


def test_the_camera_is_upright_inside_the_room_and_moves_smoothly() -> None:
    room = SyntheticRoom(2, width=16, height=12)
    poses = np.stack([room[index].pose for index in range(240)])
    assert (poses[:, 2, 1] < -0.75).all()
    assert (np.abs(poses[:, :3, 3]) < (LENGTH_M / 2, WIDTH_M / 2, HEIGHT_M)).all()
    assert np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() < 0.15
    turn = np.einsum("nij,nij->n", poses[1:, :3, :3], poses[:-1, :3, :3])
    assert np.degrees(np.arccos((turn - 1) / 2)).max() < 7
    # It comes back to where it started.
    assert np.linalg.norm(poses[-1, :3, 3] - poses[0, :3, 3]) < 0.3


def test_length_and_index_are_checked(room: SyntheticRoom) -> None:
    assert len(room) == 40
    for index in (-1, 40):
        with pytest.raises(IndexError):
            room[index]
    with pytest.raises(BadInput, match="at least 1"):
        SyntheticRoom(n_frames=0)


def test_noise_repeats_and_loses_readings_at_edges_only(room: SyntheticRoom) -> None:
    noisy = SyntheticRoom(0, n_frames=40, width=160, height=120, noise=True)
    assert np.array_equal(noisy[5].depth, noisy[5].depth)
    lost = noisy[5].depth == 0
    assert 0 < lost.mean() < 0.4
    clean = room[5].depth
    y, x = np.nonzero(lost)
    for row, column in zip(y, x, strict=True):
        patch = clean[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        assert np.ptp(patch) > 0.05


def test_a_moved_chair_stands_elsewhere_from_the_middle_on() -> None:
    room = SyntheticRoom(0, n_frames=40, width=160, height=120, moved=True)
    assert room.move is not None
    assert room.move.frame == 20
    layout = living_room(0)
    number = room.move.instance
    assert layout.things[number].class_name == "chair"
    centers = {}
    for when in (range(20), range(20, 40)):
        points = [world_points(frame)[frame.instance_ids == number] for frame in map(room.__getitem__, when)]
        centers[when.start] = np.concatenate(points).mean(axis=0)
    assert 0.7 < np.linalg.norm(centers[20] - centers[0]) < 1.4
    truth = room.truth(spacing_m=0.05)
    chair = truth.vertices[truth.instances == number]
    assert np.linalg.norm(chair.mean(axis=0)[:2] - centers[20][:2]) < 0.25
    # Only views from after the move count for the chair.
    late = [Vantage(room[i].pose, scene_of(layout.after_move().things)) for i in range(20, 40)]
    view = CameraView(room.intrinsics, (0.1, 5.0))
    expected = ground_truth(layout.after_move().things, late, view, 0.05).visible
    own = truth.instances == number
    assert np.array_equal(truth.visible[own], expected[own])


def test_truth_covers_the_surface_evenly() -> None:
    things = {4: Thing("box", (box((0, 0, 0), (0.4, 0.3, 0.2), GREY),))}
    surface = tessellate(things, 0.01)
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(2 * (0.12 + 0.08 + 0.06))
    longest = max(np.linalg.norm(p - q, axis=1).max() for p, q in ((a, b), (b, c), (c, a)))
    assert longest <= 0.01 * np.sqrt(2) + 1e-9
    # Corners and edges are shared, so that no place counts twice.
    assert len(surface.vertices) == 41 * 31 * 21 - 39 * 29 * 19
    assert len(np.unique(np.rint(surface.vertices * 1e4), axis=0)) == len(surface.vertices)


def test_truth_names_the_classes_of_the_room(room: SyntheticRoom, truth: GroundTruth) -> None:
    assert truth.instance_classes == room.classes
    seen = {int(i) for frame in map(room.__getitem__, range(40)) for i in np.unique(frame.instance_ids)}
    assert seen <= set(truth.instance_classes)
    # So few frames only glimpse the ceiling.
    assert set(np.unique(truth.instances[truth.visible])) >= set(truth.instance_classes) - {2}


def test_pixels_lie_on_truth_of_the_same_instance(room: SyntheticRoom, truth: GroundTruth) -> None:
    frame = room[7]
    points = world_points(frame).reshape(-1, 3)[::41]
    ids = frame.instance_ids.ravel()[::41]
    for point, number in zip(points, ids, strict=True):
        nearest = np.linalg.norm(truth.vertices[truth.instances == number] - point, axis=1).min()
        assert nearest < 0.05


def test_visible_equals_a_look_at_every_vertex() -> None:
    things = living_room(5).things
    camera = Intrinsics(160, 120, 131.0, 131.0, 79.5, 59.5)
    poses = list(walk_round(240, (1.75, 1.3), 5)[100:150:5])
    scene = scene_of(things)
    view = CameraView(camera, (0.1, 2.8))
    found = ground_truth(things, [Vantage(p, scene) for p in poses], view, 0.2, {9: 5})
    surface = tessellate(things, 0.2)
    counts = np.zeros(len(surface.vertices), int)
    for number, pose in enumerate(poses):
        for vertex, (point, normal) in enumerate(zip(surface.vertices, surface.normals, strict=True)):
            x, y, z = inverse(pose)[:3, :3] @ point + inverse(pose)[:3, 3]
            if not 0.1 <= z <= 2.8 or normal @ (pose[:3, 3] - point) <= 0:
                continue
            u, v = 131 * x / z + 79.5, 131 * y / z + 59.5
            if not (-0.5 < u < 159.5 and -0.5 < v < 119.5) or (surface.instances[vertex] == 9 and number < 5):
                continue
            direction = (point - pose[:3, 3]) / np.linalg.norm(point - pose[:3, 3])
            ray = np.concatenate([pose[:3, 3], direction])[None].astype(np.float32)
            reach = float(scene.cast_rays(o3d.core.Tensor(ray))["t_hit"].numpy()[0])
            counts[vertex] += reach >= np.linalg.norm(point - pose[:3, 3]) - TOLERANCE_M
    different = found.visible != (counts >= 3)
    assert found.visible.sum() > 200
    # Single precision decides ties on borders differently.
    assert different.sum() <= 3


def test_folder_round_trip(tmp_path: Path) -> None:
    room = SyntheticRoom(0, n_frames=3, width=64, height=48)
    assert write_folder(room, tmp_path / "room", lossless=True) == []
    back = open_sequence(tmp_path / "room")
    assert len(back) == 3
    assert back.has_poses
    for index in range(3):
        one, other = room[index], back[index]
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.instance_ids, other.instance_ids)
        np.testing.assert_allclose(one.depth, other.depth, atol=0.00051)
        np.testing.assert_allclose(one.pose, other.pose, atol=1e-7)
        assert one.stamp == pytest.approx(other.stamp, abs=1e-6)
        assert {k: one.instance_classes[k] for k in np.unique(one.instance_ids)} == {
            k: other.instance_classes[k] for k in np.unique(one.instance_ids)
        }
    assert back.intrinsics == room.intrinsics


def test_jpeg_is_close_and_an_existing_folder_is_left_alone(tmp_path: Path) -> None:
    room = SyntheticRoom(0, n_frames=1, width=160, height=120)
    write_folder(room, tmp_path / "room")
    assert [path.name for path in tmp_path.iterdir()] == ["room"]
    difference = open_sequence(tmp_path / "room")[0].rgb.astype(int) - room[0].rgb
    assert np.abs(difference).mean() < 4
    with pytest.raises(BadInput, match="exists"):
        write_folder(room, tmp_path / "room")


def test_unusable_frames_are_left_out_and_named(tmp_path: Path) -> None:
    class Broken(SyntheticRoom):
        def __getitem__(self, index: int) -> Frame:
            if index == 1:
                raise UnusableFrame("a broken image")
            return super().__getitem__(index)

    room = Broken(0, n_frames=3, width=32, height=24)
    assert write_folder(room, tmp_path / "room", lossless=True) == [(1, "a broken image")]
    back = open_sequence(tmp_path / "room")
    assert len(back) == 2
    assert np.array_equal(back[1].rgb, room[2].rgb)
    np.testing.assert_allclose(back[1].pose, room[2].pose, atol=1e-7)


def test_truth_round_trip(truth: GroundTruth, tmp_path: Path) -> None:
    write_truth(truth, tmp_path / "truth")
    back = read_truth(tmp_path / "truth")
    for name in ("vertices", "triangles", "instances", "classes", "visible"):
        assert np.array_equal(getattr(truth, name), getattr(back, name))
    assert back.class_names == truth.class_names
    mesh = tmp_path / "truth" / "mesh.ply"
    mesh.write_bytes(mesh.read_bytes()[:-7])
    with pytest.raises(BadInput, match="cut short"):
        read_truth(tmp_path / "truth")
    mesh.write_bytes(b"ply\nformat ascii 1.0\nend_header\n")
    with pytest.raises(BadInput, match="no vertex property x"):
        read_truth(tmp_path / "truth")
    mesh.unlink()
    with pytest.raises(BadInput, match="missing"):
        read_truth(tmp_path / "truth")
