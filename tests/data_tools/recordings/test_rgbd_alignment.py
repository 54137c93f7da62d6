"""Colour brought onto the depth grid, against geometry that can be worked out by hand."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.rgbd_alignment import make_rgbd_alignment
from razer.errors import BadInput
from tests.support.recordings import HEIGHT, WIDTH, camera_json, colour, depth, write_folder, write_image

BARREL = (0.25, -0.6, 0.003, -0.002, 0.4)


def test_equal_sizes_without_distortion_pass_untouched() -> None:
    registration = make_rgbd_alignment(Declared(Camera(10, 10, 3.5, 2.5)), (8, 6), (8, 6))
    rgb, metres = colour(), depth().astype(np.float32)
    color, has_color, recorded = registration.color(rgb, metres)
    assert color is rgb
    assert has_color is None
    assert recorded is None, "this is the picture as it was recorded"
    assert registration.on_depth_grid(metres) is metres


def test_colour_of_twice_the_resolution_is_averaged(tmp_path: Path) -> None:
    write_folder(tmp_path, camera=camera_json())
    fine = np.kron(colour(7), np.ones((2, 2, 1), np.uint8))
    for i in range(3):
        write_image(tmp_path / "color" / f"{i:06d}.png", fine)
    sequence = open_sequence(tmp_path)
    np.testing.assert_array_equal(sequence[0].rgb, colour(7))
    assert sequence.intrinsics.fx == 10


def test_a_camera_calibrated_on_the_colour_size_is_scaled(tmp_path: Path) -> None:
    camera = {"width": 16, "height": 12, "fx": 20.0, "fy": 20.0, "cx": 7.5, "cy": 5.5}
    write_folder(tmp_path, camera=camera)
    for i in range(3):
        write_image(tmp_path / "color" / f"{i:06d}.png", colour(width=16, height=12))
    found = open_sequence(tmp_path).intrinsics
    # Pixel centres: the principal point at 7.5 of 16 is the middle, 3.5 of 8.
    assert (found.width, found.fx, found.cx, found.cy) == (8, 10, 3.5, 2.5)


@pytest.mark.parametrize(
    ("color_size", "camera"),
    [((16, 12), None), ((10, 6), None), ((10, 6), camera_json()), ((8, 6), camera_json(width=9))],
)
def test_unknown_relations_are_refused(tmp_path: Path, color_size: tuple[int, int], camera: dict | None) -> None:
    write_folder(tmp_path, camera=camera)
    for i in range(3):
        write_image(tmp_path / "color" / f"{i:06d}.png", colour(0, *color_size))
    with pytest.raises(BadInput, match=r"relation is unknown|correct width and height"):
        open_sequence(tmp_path, camera=None if camera else "10,10,3.5,2.5")


def test_two_cameras_need_an_extrinsic(tmp_path: Path) -> None:
    other = camera_json(fx=13.0)
    write_folder(tmp_path, camera=camera_json(color=other))
    with pytest.raises(BadInput, match="--depth-to-color"):
        open_sequence(tmp_path)
    (tmp_path / "intrinsics.json").write_text(json.dumps(camera_json(color=camera_json())))
    np.testing.assert_array_equal(open_sequence(tmp_path)[0].rgb, colour(0))


@pytest.mark.parametrize(("units", "shift"), [(1000, 2), (2000, 1)])
def test_a_colour_camera_beside_the_depth_camera(tmp_path: Path, units: int, shift: int) -> None:
    """The colour camera stands 0.2 m to the left: a point at depth z is seen f b / z = 10 * 0.2 / z pixels
    further right in colour."""
    write_folder(tmp_path, camera=camera_json())
    write_image(tmp_path / "depth" / "000000.png", depth(units))
    extrinsic = np.eye(4)
    extrinsic[0, 3] = 0.2
    np.savetxt(tmp_path / "extrinsic.txt", extrinsic)
    rgb = open_sequence(tmp_path, depth_to_color=tmp_path / "extrinsic.txt")[0].rgb
    np.testing.assert_array_equal(rgb[:, : WIDTH - shift], colour(0)[:, shift:])
    assert not rgb[:, WIDTH - shift :].any()  # where the colour camera does not look


def test_each_pixel_is_moved_by_its_own_depth() -> None:
    extrinsic = np.eye(4)
    extrinsic[0, 3] = 0.2
    camera = Camera(10, 10, 3.5, 2.5)
    registration = make_rgbd_alignment(Declared(camera, color_from_depth=extrinsic), (8, 6), (8, 6))
    metres = np.full((6, 8), 2.0, np.float32)
    metres[:3] = 1.0
    metres[5] = 0.0  # as far as the nearest pixel that has a depth
    metres[2] = 2.0
    rgb, has_color, recorded = registration.color(colour(), metres)
    assert has_color is not None
    assert recorded is not None
    np.testing.assert_array_equal(recorded.rgb, colour())
    row, column = np.divmod(recorded.pixel, 8)
    np.testing.assert_array_equal(rgb[has_color], recorded.rgb[row, column][has_color])  # moved by whole pixels
    np.testing.assert_array_equal(has_color[3], np.arange(8) < 7)  # moved by 1 pixel: the last is not seen
    np.testing.assert_array_equal(rgb[0, :6, 1], np.arange(2, 8))
    np.testing.assert_array_equal(rgb[3, :7, 1], np.arange(1, 8))
    np.testing.assert_array_equal(rgb[5, :7, 1], np.arange(1, 8))


def test_a_turned_colour_camera_of_another_resolution(tmp_path: Path) -> None:
    """Upside down and twice as fine: depth pixel (u, v) is colour pixel (14.5 - 2 u, 10.5 - 2 v)."""
    color_camera = {"width": 16, "height": 12, "fx": 20.0, "fy": 20.0, "cx": 7.5, "cy": 5.5}
    write_folder(tmp_path, camera=camera_json(color=color_camera))
    for i in range(3):
        write_image(tmp_path / "color" / f"{i:06d}.png", colour(0, 16, 12))
    np.savetxt(tmp_path / "extrinsic.txt", np.diag([-1.0, -1.0, 1.0, 1.0]))
    rgb = open_sequence(tmp_path, depth_to_color=tmp_path / "extrinsic.txt")[0].rgb
    # x = (u - 3.5) z / 10 -> u' = 7.5 - 20 x / z = 14.5 - 2 u, half way between two columns; rows alike.
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    np.testing.assert_allclose(rgb[..., 1], 14.5 - 2 * u, atol=0.51)
    np.testing.assert_allclose(rgb[..., 2], 10.5 - 2 * v, atol=0.51)


@pytest.mark.parametrize("content", ["1 2 3 4", "nonsense", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", None])
def test_an_extrinsic_must_be_a_rigid_matrix(tmp_path: Path, content: str | None) -> None:
    write_folder(tmp_path, camera=camera_json())
    path = tmp_path / "extrinsic.txt"
    if content is not None:
        path.write_text(content)
    with pytest.raises(BadInput, match=r"extrinsic\.txt"):
        open_sequence(tmp_path, depth_to_color=path)


def test_undistorted_images_follow_the_pinhole() -> None:
    """Points drawn where the distorted camera sees them must appear where the pinhole sees them."""
    camera = Camera(300, 310, 158, 121, BARREL)
    registration = make_rgbd_alignment(Declared(camera), (320, 240), (320, 240))
    rays = np.array([[-0.35, -0.25, 1], [0.3, -0.2, 1], [0.0, 0.0, 1], [0.38, 0.28, 1], [-0.3, 0.3, 1]])
    rgb, metres = np.zeros((240, 320, 3), np.uint8), np.zeros((240, 320), np.float32)
    matrix = camera.at((320, 240)).matrix
    distorted = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, np.array(BARREL))[0][:, 0]
    for i, (u, v) in enumerate(np.rint(distorted).astype(int), start=1):
        rgb[v - 2 : v + 3, u - 2 : u + 3] = 40 * i
        metres[v - 2 : v + 3, u - 2 : u + 3] = i
    straight = registration.on_depth_grid(metres)
    expected = rays @ matrix.T
    moved = np.linalg.norm(distorted - expected[:, :2], axis=1)
    assert moved.max() > 4  # or the test would pass without undistortion
    for i, (u, v, _) in enumerate(np.rint(expected).astype(int), start=1):
        assert straight[v, u] == i
        assert (registration.color(rgb, straight)[0][v, u] == 40 * i).all()
    assert set(np.unique(straight)) <= {0, 1, 2, 3, 4, 5}  # depths are never mixed


def test_distortion_from_the_command_line(tmp_path: Path) -> None:
    write_folder(tmp_path)
    sequence = open_sequence(tmp_path, camera="10,10,3.5,2.5," + ",".join(map(str, BARREL)))
    assert sequence[0].rgb.shape == (HEIGHT, WIDTH, 3)
    assert not np.array_equal(sequence[0].rgb, colour(0))
