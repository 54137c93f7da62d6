"""Bags of ROS 1 and ROS 2: topics are found, images decoded, poses put together from transforms."""

from __future__ import annotations

import pickle
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from tests.support.recordings import HEIGHT, WIDTH, colour, depth

pytest.importorskip("rosbags")
from tests.support.ros_recordings import KINDS, Messages, compressed_depth_head, write_bag

SIZE = (WIDTH, HEIGHT)
K = (10.0, 11.0, 3.5, 2.5)
COLOR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
START = 1700000000.0
OPTICAL = "camera_color_optical_frame"
MOUNT = Rotation.from_euler("xyz", [-90, 0, -90], degrees=True)  # an optical frame on a robot that drives along x


def camera_messages(make: Messages, frames: int = 4) -> list[tuple[str, float, Any]]:
    """Image i has red = i and 1000 + i millimetres; depth comes 4 ms after colour; bag times are a second late."""
    found: list[tuple[str, float, Any]] = []
    for topic in (COLOR, DEPTH):
        info = make.info(OPTICAL, SIZE, K)
        found.append((topic.rpartition("/")[0] + "/camera_info", START, info))
    for i in range(frames):
        stamp = START + i / 30
        found.append((COLOR, stamp + 1, make.image(stamp, OPTICAL, colour(i), "rgb8")))
        found.append((DEPTH, stamp + 1, make.image(stamp + 0.004, OPTICAL, depth(1000 + i), "16UC1")))
    return found


def decoys(make: Messages) -> list[tuple[str, float, Any]]:
    """What a RealSense records besides: infrared, and depth of its own, unregistered camera."""
    gray = make.image(START, "infra", colour()[..., 0].copy(), "mono8")
    own = make.image(START, "camera_depth_optical_frame", depth(500), "16UC1")
    return [("/camera/infra1/image_rect_raw", START, gray), ("/camera/depth/image_rect_raw", START, own)]


def robot(make: Messages, steps: int = 12) -> list[tuple[str, float, Any]]:
    """A robot driving 1 m/s along x of the map at 30 poses a second, with its camera mounted 0.5 m up."""
    found = [("/tf_static", START, make.transform(START, "base_link", f"/{OPTICAL}", (0, 0, 0.5), MOUNT.as_quat()))]
    for i in range(steps):
        stamp = START + (i - 2) / 30
        found.append(("/tf", stamp, make.transform(stamp, "map", "base_link", ((i - 2) / 30, 0, 0), (0, 0, 0, 1))))
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_recorded_camera_on_a_robot(tmp_path: Path, kind: str) -> None:
    make = Messages(kind)
    path = write_bag(tmp_path / "drive", kind, camera_messages(make) + decoys(make) + robot(make))
    assert recognise(path) == "ros"
    sequence = pickle.loads(pickle.dumps(open_sequence(path)))
    assert (sequence.name, len(sequence), sequence.has_poses) == ("drive", 4, True)
    assert sequence.intrinsics == Intrinsics(WIDTH, HEIGHT, *K)
    for i in (3, 0, 2, 1, 3):
        frame = sequence[i]
        np.testing.assert_array_equal(frame.rgb, colour(i))
        np.testing.assert_array_equal(frame.depth, np.float32((1000 + i) / 1000))
        assert frame.stamp == pytest.approx(START + i / 30 + 0.004, abs=1e-6)
        np.testing.assert_allclose(frame.pose[:3, 3], [i / 30 + 0.004, 0, 0.5], atol=1e-5)
        np.testing.assert_allclose(frame.pose[:3, :3] @ [0, 0, 1], [1, 0, 0], atol=1e-9)  # it looks ahead
    with pytest.raises(IndexError):
        sequence[4]


def test_poses_of_the_camera_itself_serve_where_nothing_else_moves(tmp_path: Path) -> None:
    make = Messages("ros1")
    turn = Rotation.from_euler("z", 10, degrees=True).as_quat()
    track = [("/vicon/camera", START, make.pose(START + i / 50, "world", (i, 0, 0), turn)) for i in range(12)]
    sequence = open_sequence(write_bag(tmp_path / "bag", "ros1", camera_messages(make) + track))
    assert sequence[1].pose[0, 3] == pytest.approx((1 / 30 + 0.004) * 50, abs=1e-4)
    assert not open_sequence(tmp_path / "bag.bag", use_poses=False).has_poses


def test_a_frame_outside_the_transforms_costs_itself_alone(tmp_path: Path) -> None:
    make = Messages("sqlite3")
    path = write_bag(tmp_path / "bag", "sqlite3", camera_messages(make, 4) + robot(make, 5))
    sequence = open_sequence(path)
    assert sequence[1].pose[0, 3] > 0
    with pytest.raises(UnusableFrame, match="does not cover"):
        sequence[3]


def encoded(make: Messages, name: str, stamp: float) -> tuple[Any, Any]:
    """(colour, depth) messages of red = 9 and 1.5 m in one of many encodings."""
    image, metres = colour(9), np.full((HEIGHT, WIDTH), 1.5, np.float32)
    plain = make.image(stamp, OPTICAL, depth(1500), "16UC1")
    return {
        "bgr8": (make.image(stamp, OPTICAL, image[..., ::-1], "bgr8"), plain),
        "bgra8": (make.image(stamp, OPTICAL, cv2.cvtColor(image, cv2.COLOR_RGB2BGRA), "bgra8"), plain),
        "rows with padding": (
            make.image(stamp, OPTICAL, image, "rgb8", padding=3),
            make.image(stamp, OPTICAL, depth(1500), "16UC1", padding=6),
        ),
        "big-endian": (
            make.image(stamp, OPTICAL, image, "rgb8"),
            make.image(stamp, OPTICAL, depth(1500).astype(">u2"), "16UC1"),
        ),
        "32FC1": (make.image(stamp, OPTICAL, image, "rgb8"), make.image(stamp, OPTICAL, metres, "32FC1")),
        "compressed": (
            make.compressed(stamp, OPTICAL, image, "rgb8; png compressed bgr8"),
            make.compressed(stamp, OPTICAL, depth(1500), "16UC1; compressedDepth png", compressed_depth_head(0, 0)),
        ),
        # 1.5 = a / (v - b) with a = 600, b = 100 and v = 500
        "compressed 32FC1": (
            make.image(stamp, OPTICAL, image, "rgb8"),
            make.compressed(stamp, OPTICAL, depth(500), "32FC1; compressedDepth", compressed_depth_head(600, 100)),
        ),
    }[name]  # fmt: skip


ENCODINGS = ("bgr8", "bgra8", "rows with padding", "big-endian", "32FC1", "compressed", "compressed 32FC1")


@pytest.mark.parametrize("name", ENCODINGS)
def test_encodings(tmp_path: Path, name: str) -> None:
    make = Messages("mcap")
    color, deep = encoded(make, name, START)
    info = make.info(OPTICAL, SIZE, K)
    found = [("/cam/rgb/image_raw", START, color), ("/cam/depth_registered/image_raw/x", START, deep)]
    frame = open_sequence(write_bag(tmp_path / "bag", "mcap", [*found, ("/cam/rgb/camera_info", START, info)]))[0]
    np.testing.assert_array_equal(frame.rgb, colour(9))
    np.testing.assert_allclose(frame.depth, 1.5, atol=1e-6)


def test_nan_infinite_and_missing_depth_are_none(tmp_path: Path) -> None:
    make = Messages("mcap")
    metres = np.array([[np.nan, np.inf, -1.0, 0.0, 2.0, 2.0, 2.0, 2.0]] * HEIGHT, np.float32)
    found = [(COLOR, START, make.image(START, OPTICAL, colour(), "rgb8"))]
    found += [(DEPTH, START, make.image(START, OPTICAL, metres, "32FC1"))]
    found += [("/camera/color/camera_info", START, make.info(OPTICAL, SIZE, K))]
    frame = open_sequence(write_bag(tmp_path / "bag", "mcap", found))[0]
    np.testing.assert_array_equal(frame.depth[0], [0, 0, 0, 0, 2, 2, 2, 2])


def unregistered(make: Messages, shift: float | None) -> list[tuple[str, float, Any]]:
    """Depth and colour of two cameras side by side, `shift` metres apart by tf_static, or of unknown relation."""
    found = [("/camera/color/camera_info", START, make.info("color", SIZE, K))]
    found += [("/camera/depth/camera_info", START, make.info("depth", SIZE, (9.0, 9.0, 3.5, 2.5)))]
    found += [(COLOR, START, make.image(START, "color", colour(3), "rgb8"))]
    found += [("/camera/depth/image_rect_raw", START, make.image(START, "depth", depth(1000), "16UC1"))]
    if shift is not None:
        found += [("/tf_static", START, make.transform(START, "body", "color", (0, 0, 0), (0, 0, 0, 1)))]
        found += [("/tf_static", START, make.transform(START, "body", "depth", (shift, 0, 0), (0, 0, 0, 1)))]
    return found


def test_colour_of_another_camera_is_brought_onto_depth_by_tf(tmp_path: Path) -> None:
    make = Messages("sqlite3")
    frame = open_sequence(write_bag(tmp_path / "bag", "sqlite3", unregistered(make, 0.1)))[0]
    assert frame.intrinsics.fx == 9
    # Column 3 of depth at 1 m lies at x = (3 - 3.5) / 9 + 0.1 m for the colour camera; green is its column there.
    assert frame.rgb[2, 3, 1] == pytest.approx(10 * ((3 - 3.5) / 9 + 0.1) + 3.5, abs=0.5)


def test_an_unknown_relation_of_two_cameras_is_one_line(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bag", "sqlite3", unregistered(Messages("sqlite3"), None))
    with pytest.raises(BadInput, match="--depth-to-color") as caught:
        open_sequence(path)
    assert "\n" not in str(caught.value)


def test_topics_json_chooses(tmp_path: Path) -> None:
    make = Messages("ros1")
    other = make.image(START + 0.004, OPTICAL, depth(3000), "16UC1")
    messages = [*camera_messages(make), ("/better/depth", START, other)]
    path = write_bag(tmp_path / "bag", "ros1", messages)
    assert open_sequence(path)[0].depth[0, 0] == 1
    path.with_suffix(".topics.json").write_text('{"depth": "/better/depth"}')
    sequence = open_sequence(path, camera="10,10,3.5,2.5")
    assert (len(sequence), sequence[0].depth[0, 0]) == (1, 3)
    path.with_suffix(".topics.json").write_text('{"depth": "/nowhere"}')
    with pytest.raises(BadInput, match=r"no topic /nowhere; its topics are: /better/depth \(Image\)"):
        open_sequence(path)


def test_header_stamps_that_are_not_set_give_way_to_the_time_in_the_bag(tmp_path: Path) -> None:
    make = Messages("sqlite3")
    found = [("/camera/color/camera_info", START, make.info(OPTICAL, SIZE, K))]
    for i in range(3):
        found.append((COLOR, START + i, make.image(0, OPTICAL, colour(i), "rgb8")))
        found.append((DEPTH, START + i + 0.01, make.image(0, OPTICAL, depth(1000 + i), "16UC1")))
    sequence = open_sequence(write_bag(tmp_path / "bag", "sqlite3", found))
    assert [sequence[i].rgb[0, 0, 0] for i in range(3)] == [0, 1, 2]
    assert sequence[2].stamp == pytest.approx(START + 2.01)


def broken(tmp_path: Path, fault: str) -> Path:
    make = Messages("ros1")
    if fault == "no depth":
        messages = [item for item in camera_messages(make) if item[0] != DEPTH]
    elif fault == "no camera":
        messages = [item for item in camera_messages(make) if not item[0].endswith("info")]
    elif fault == "distortion of eight":
        info = make.info(OPTICAL, SIZE, K, (0.1,) * 8)
        messages = [(t, s, info if t.endswith("info") else m) for t, s, m in camera_messages(make)]
    elif fault == "apart in time":
        messages = [(t, s, m) for t, s, m in camera_messages(make) if t != DEPTH]
        messages += [(DEPTH, START, make.image(START + 99, OPTICAL, depth(), "16UC1"))]
    else:
        messages = camera_messages(make)
    path = write_bag(tmp_path / "bag", "ros1", messages)
    if fault == "cut off":
        path.write_bytes(path.read_bytes()[:-2000])
    if fault == "no bag":
        path.write_text("nothing")
    return path


FAULTS = {
    "no depth": r"has no depth images; its topics are: .*color/image_raw \(Image\)",
    "no camera": "--intrinsics fx,fy,cx,cy",
    "distortion of eight": "rational_polynomial with 8 numbers",
    "apart in time": "within 0.02 s",
    "cut off": "cannot be opened as a ROS bag",
    "no bag": "cannot be opened as a ROS bag",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_cannot_be_used_is_one_line(tmp_path: Path, fault: str) -> None:
    path = broken(tmp_path, fault)
    with pytest.raises(BadInput, match=FAULTS[fault]) as caught:
        open_sequence(path)
    assert "\n" not in str(caught.value)


def test_without_the_package_the_fix_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_bag(tmp_path / "bag", "ros1", camera_messages(Messages("ros1")))
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(BadInput, match=r"pip install 'razer\[ros\]'"):
        open_sequence(path)
