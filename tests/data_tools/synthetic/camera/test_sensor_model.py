"""The sensor model: each error against its formula, absent when off, the same in any order."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.synthetic.camera.color_errors import blur_px, exposure, rolling_offset_px
from data_tools.synthetic.camera.depth_errors import GRAZING_DEG
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.errors import BadInput
from razer.frame import Intrinsics

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
STILL = np.repeat(np.eye(4)[None], 200, axis=0)
KINECT = SensorModel.kinect()


def wall(distance_m: float) -> np.ndarray:
    return np.full((240, 320), distance_m, np.float32)


def tilted(angle_deg: float) -> np.ndarray:
    """A plane through (0, 0, 2) whose normal is turned by an angle from the optical axis, about y."""
    x = (np.arange(320) - CAMERA.cx) / CAMERA.fx
    slope = np.tan(np.radians(angle_deg))
    inverse = np.tile((1 - slope * x) / 2, (240, 1))
    return np.where(inverse > 0.05, 1 / np.maximum(inverse, 0.05), 0).astype(np.float32)


def pattern(seed: int = 0) -> np.ndarray:
    """A smooth colour pattern within the greys that noise and exposure leave unclipped."""
    rough = np.random.default_rng(seed).uniform(60, 180, (240, 320, 3)).astype(np.float32)
    smooth = cv2.GaussianBlur(rough, None, 3)
    return np.clip((smooth - 120) * 8 + 120, 60, 180).astype(np.uint8)


def read_depth(model: SensorModel, true: np.ndarray, index: int = 0, seed: int = 0) -> np.ndarray:
    return model.observe(np.zeros((*true.shape, 3), np.uint8), true, CAMERA, STILL, index=index, seed=seed)[1]


def read_colour(model: SensorModel, poses: np.ndarray = STILL, index: int = 0, seed: int = 0) -> np.ndarray:
    return model.observe(pattern(), wall(2), CAMERA, poses, index=index, seed=seed)[0].astype(float)


def turning(step_deg: float, axis: tuple[int, int, int] = (0, 1, 0), n_frames: int = 3) -> np.ndarray:
    poses = np.repeat(np.eye(4)[None], n_frames, axis=0)
    poses[:, :3, :3] = Rotation.from_rotvec(np.radians(step_deg) * np.outer(np.arange(n_frames), axis)).as_matrix()
    return poses


@pytest.mark.parametrize("distance_m", [1.0, 2.0, 4.0])
def test_noise_along_the_axis_is_that_of_the_paper(distance_m: float) -> None:
    sigma = 0.0012 + 0.0019 * (distance_m - 0.4) ** 2
    for strength in (1.0, 0.5):
        error = read_depth(SensorModel(axial_noise=strength), wall(distance_m)) - distance_m
        assert error.std() == pytest.approx(strength * sigma, rel=0.02)
        assert abs(error.mean()) < 4 * strength * sigma / np.sqrt(error.size)
        # Gaussian, and independent between neighbours.
        assert (np.abs(error) > 2 * strength * sigma).mean() == pytest.approx(0.0455, abs=0.004)
        assert abs(np.corrcoef(error[:, 1:].ravel(), error[:, :-1].ravel())[0, 1]) < 0.02


def test_noise_along_the_axis_averages_out_over_frames() -> None:
    model = SensorModel(axial_noise=1.0)
    mean = np.mean([read_depth(model, wall(2), index) for index in range(50)], axis=0)
    sigma = 0.0012 + 0.0019 * 1.6**2
    assert (mean - 2).std() == pytest.approx(sigma / np.sqrt(50), rel=0.1)


def test_noise_across_the_image_is_in_pixels() -> None:
    # Depth tells the column, finely enough for one pixel.
    ramp = np.tile(np.linspace(1, 4, 320, dtype=np.float32), (240, 1))
    columns = np.rint((read_depth(SensorModel(lateral_noise_px=2.0), ramp) - 1) / 3 * 319)
    error = (columns - np.arange(320))[:, 10:-10]
    assert error.std() == pytest.approx(np.hypot(2, 1 / np.sqrt(12)), rel=0.02)
    assert abs(error.mean()) < 0.05
    assert np.array_equal(read_depth(SensorModel(lateral_noise_px=2.0), wall(2)), wall(2))


def test_steps_of_disparity_grow_with_the_square_of_depth() -> None:
    step_per_m = KINECT.disparity_step_per_m
    assert step_per_m == pytest.approx(1 / (8 * 580 * 0.075))
    ramp = np.linspace(0.9, 4.1, 240 * 320).reshape(240, 320).astype(np.float32)
    read = read_depth(SensorModel(disparity_step_per_m=step_per_m), ramp)
    steps, values = np.diff(np.unique(read)), np.unique(read)
    for z in (1.0, 2.0, 4.0):
        nearest = np.abs((values[1:] + values[:-1]) / 2 - z).argmin()
        assert steps[nearest] == pytest.approx(z**2 * step_per_m, rel=0.03)
    assert np.abs(1 / read - 1 / ramp).max() < 0.501 * step_per_m


def test_depth_comes_in_whole_millimetres() -> None:
    ramp = np.linspace(0.5, 8, 240 * 320).reshape(240, 320).astype(np.float32)
    read = read_depth(SensorModel(depth_step_m=0.001), ramp)
    assert np.array_equal(read, (np.rint(read * 1000.0) / np.float32(1000)).astype(np.float32))
    assert np.abs(read - ramp).max() <= 0.00051


def test_readings_are_lost_where_a_surface_is_seen_edge_on() -> None:
    model = SensorModel(grazing_dropout=1.0)
    lost = {}
    for angle in (0, 40, 60, 75, 80, 87):
        # The middle of the image, where the ray is the axis.
        read = read_depth(model, tilted(angle))
        lost[angle] = (read[:, 156:164] == 0).mean()
    assert lost[0] == lost[40] == lost[60] == 0
    low, high = (np.cos(np.radians(a)) for a in GRAZING_DEG)
    for angle in (75, 80):
        assert lost[angle] == pytest.approx((low - np.cos(np.radians(angle))) / (low - high), abs=0.06)
    assert lost[87] == 1
    half = read_depth(SensorModel(grazing_dropout=0.5), tilted(87))[:, 156:164]
    assert (half == 0).mean() == pytest.approx(0.5, abs=0.05)


def test_a_wall_has_no_grazing_rays_whatever_the_edges_in_it() -> None:
    boxes = wall(3)
    boxes[60:180, 100:200] = 1.5
    assert np.array_equal(read_depth(SensorModel(grazing_dropout=1.0), boxes), boxes)


def test_readings_are_lost_along_edges_only() -> None:
    boxes = wall(3)
    boxes[60:180, 100:200] = 1.5
    lost = np.mean([read_depth(SensorModel(edge_dropout=0.3), boxes, index) == 0 for index in range(20)], axis=0)
    touched = np.zeros(boxes.shape, bool)
    touched[59:181, 99:201] = True
    touched[61:179, 101:199] = False
    assert lost[~touched].max() == 0
    assert lost[touched].mean() == pytest.approx(0.3, abs=0.02)


def test_nothing_is_read_outside_the_range() -> None:
    ramp = np.linspace(0.2, 8, 240 * 320).reshape(240, 320).astype(np.float32)
    read = read_depth(SensorModel(range_m=(0.5, 5.0)), ramp)
    assert np.array_equal(read, np.where((ramp >= 0.5) & (ramp <= 5), ramp, 0))


def test_no_reading_stays_no_reading() -> None:
    assert not read_depth(KINECT, wall(0)).any()


def test_colour_noise_has_the_said_deviation_on_each_channel() -> None:
    error = read_colour(SensorModel(colour_noise=4.0)) - pattern()
    assert error.std() == pytest.approx(np.hypot(4, 1 / np.sqrt(12)), rel=0.02)
    assert abs(error.mean()) < 0.05
    assert abs(np.corrcoef(error[..., 0].ravel(), error[..., 1].ravel())[0, 1]) < 0.02


def test_exposure_drifts_slowly_within_its_share() -> None:
    gains = np.array([exposure(0.2, 7, index) for index in range(2000)])
    assert np.abs(gains - 1).max() <= 0.2
    assert np.ptp(gains) > 0.15
    assert np.abs(np.diff(gains)).max() < 0.02
    index = int(gains[:200].argmin())
    read = read_colour(SensorModel(exposure_drift=0.2), index=index, seed=7)
    assert (read / pattern()).mean() == pytest.approx(gains[index], rel=0.005)
    assert exposure(0.2, 8, 0) != gains[0]


@pytest.mark.parametrize("size_px", [0.5, 2.0, 4.0])
def test_misregistration_shifts_colour_by_the_said_pixels(size_px: float) -> None:
    for index in (0, 60, 130):
        offset = rolling_offset_px(size_px, 3, index)
        assert np.hypot(*offset) == pytest.approx(size_px)
        moved = read_colour(SensorModel(misregistration_px=size_px), index=index, seed=3)
        window = np.outer(np.hanning(240), np.hanning(320))
        grey = pattern().mean(axis=2)
        found, _ = cv2.phaseCorrelate(grey - grey.mean(), moved.mean(axis=2) - grey.mean(), window)
        assert np.allclose(found, offset, atol=0.15)


def test_the_shift_turns_slowly() -> None:
    offsets = np.array([rolling_offset_px(1.5, 0, index) for index in range(400)])
    assert np.linalg.norm(np.diff(offsets, axis=0), axis=1).max() < 0.06
    assert (np.ptp(offsets, axis=0) > 2.9).all()


def test_motion_blurs_along_the_way_by_the_cameras_rotation() -> None:
    model = SensorModel(shutter=0.5)
    bar = np.zeros((240, 320, 3), np.uint8)
    bar[100:140, 160] = 240
    for step_deg in (1.0, 3.0, 6.0, 15.0):
        expected_px = 0.5 * CAMERA.fx * np.tan(np.radians(step_deg))
        poses = turning(step_deg)
        assert np.allclose(np.abs(blur_px(poses, 1, CAMERA, 0.5)), (expected_px, 0))
        rgb, _ = model.observe(bar, wall(2), CAMERA, poses, index=1, seed=0)
        profile = rgb[120, :, 0].astype(float)
        width = np.sqrt(np.average((np.arange(320) - 160) ** 2, weights=profile))
        assert width == pytest.approx(np.hypot(expected_px / np.sqrt(12), 0.35), rel=0.1)
        assert np.average(np.arange(320), weights=profile) == pytest.approx(160, abs=0.3)
        # Interpolation between pixels adds about 0.35; nothing is smeared the other way.
        assert rgb[:99].max() == rgb[141:].max() == 0


def test_a_camera_at_rest_or_moving_along_is_sharp() -> None:
    sliding = STILL.copy()
    sliding[:, 0, 3] = np.arange(200)
    assert np.array_equal(read_colour(SensorModel(shutter=1.0), sliding, index=5), pattern())


def test_the_first_frame_is_blurred_like_the_second_and_a_lone_one_not() -> None:
    poses = turning(4.0, (1, 0, 0))
    assert np.allclose(np.abs(blur_px(poses, 0, CAMERA, 0.3)), np.abs(blur_px(poses, 1, CAMERA, 0.3)))
    assert not blur_px(poses[:1], 0, CAMERA, 0.3).any()


def test_a_sensor_without_error_changes_nothing() -> None:
    room = SyntheticRoom(1, n_frames=2, width=64, height=48)
    same = SyntheticRoom(1, n_frames=2, width=64, height=48, sensor=SensorModel.none())
    assert np.array_equal(room[1].rgb, same[1].rgb)
    assert np.array_equal(room[1].depth, same[1].depth)


def test_frames_are_the_same_in_any_order_and_differ_between_seeds() -> None:
    one, other = (SyntheticRoom(1, n_frames=6, width=160, height=120, sensor=KINECT) for _ in range(2))
    for index in (3, 0, 5):
        first = one[index]
        other[(index + 1) % 6]
        second = other[index]
        assert np.array_equal(first.rgb, second.rgb)
        assert np.array_equal(first.depth, second.depth)
    model = SensorModel(axial_noise=1.0, colour_noise=3.0)
    assert not np.array_equal(read_depth(model, wall(2), 0, 0), read_depth(model, wall(2), 0, 1))
    assert not np.array_equal(read_depth(model, wall(2), 0), read_depth(model, wall(2), 1))


@pytest.mark.parametrize(
    "wrong", [{"axial_noise": -1.0}, {"edge_dropout": 1.5}, {"range_m": (3.0, 2.0)}, {"colour_noise": float("nan")}]
)
def test_impossible_sensors_are_refused(wrong: dict) -> None:
    with pytest.raises(BadInput, match=next(iter(wrong)).split("_")[0]):
        SensorModel(**wrong)
