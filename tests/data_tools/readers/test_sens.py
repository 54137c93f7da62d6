"""Files of ScanNet's .sens format, made byte by byte from its description, whole, cut short and damaged."""

from __future__ import annotations

import pickle
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.synthetic_room import FRAMES_PER_S, SyntheticRoom
from data_tools.writers.scannet import write_scannet
from razer.errors import BadInput, UnusableFrame
from tests.support.recordings import colour

WIDTH, HEIGHT = 8, 6
INTRINSIC = np.array([[10, 0, 3.5, 0], [0, 11, 2.5, 0], [0, 0, 1, 0], [0, 0, 0, 1]], np.float32)
IDENTITY = np.eye(4, dtype=np.float32)
RAW, PNG, JPEG = 0, 1, 2
RAW_USHORT, ZLIB_USHORT, OCCI_USHORT = 0, 1, 2


def pose_of(i: int) -> np.ndarray:
    pose = np.eye(4, dtype=np.float32)
    pose[:3, 3] = i, 2 * i, 3 * i
    return pose


def depth_of(i: int) -> np.ndarray:
    return np.arange(WIDTH * HEIGHT, dtype=np.uint16).reshape(HEIGHT, WIDTH) * 100 + 1000 * i


def header(color_kind: int = PNG, depth_kind: int = ZLIB_USHORT, frames: int = 4, **changed: Any) -> bytes:
    told: dict[str, Any] = {"version": 4, "shift": 1000.0, "name": b"StructureSensor", "color": INTRINSIC}
    told |= {"extrinsic": IDENTITY, "color_extrinsic": IDENTITY} | changed
    name, matrices = told["name"], (told["color"], told["color_extrinsic"], INTRINSIC, told["extrinsic"])
    data = struct.pack("<I", told["version"]) + struct.pack("<Q", len(name)) + name
    data += b"".join(np.asarray(matrix, "<f4").tobytes() for matrix in matrices)
    data += struct.pack("<ii", color_kind, depth_kind) + struct.pack("<IIII", WIDTH, HEIGHT, WIDTH, HEIGHT)
    return data + struct.pack("<f", told["shift"]) + struct.pack("<Q", frames)


def frame_bytes(
    i: int, color_kind: int = PNG, depth_kind: int = ZLIB_USHORT, pose: np.ndarray | None = None, stamp_us: int = 0
) -> bytes:
    rgb = colour(i)
    suffix = {PNG: ".png", JPEG: ".jpg"}.get(color_kind)
    color = rgb.tobytes() if suffix is None else cv2.imencode(suffix, rgb[..., ::-1])[1].tobytes()
    depth = depth_of(i).astype("<u2").tobytes()
    depth = zlib.compress(depth) if depth_kind == ZLIB_USHORT else depth
    head = np.asarray(pose_of(i) if pose is None else pose, "<f4").tobytes()
    stamp = stamp_us or 5_000_000 + 33_333 * i
    return head + struct.pack("<QQQQ", stamp - 7, stamp, len(color), len(depth)) + color + depth


IMU = struct.pack("<Q", 1) + b"\0" * 128


def whole(color_kind: int = PNG, depth_kind: int = ZLIB_USHORT, frames: int = 4) -> bytes:
    parts = [frame_bytes(i, color_kind, depth_kind) for i in range(frames)]
    return header(color_kind, depth_kind, frames) + b"".join(parts) + IMU


def write(path: Path, data: bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("color_kind", [RAW, PNG, JPEG])
@pytest.mark.parametrize("depth_kind", [RAW_USHORT, ZLIB_USHORT])
def test_every_compression_is_read_in_any_order(tmp_path: Path, color_kind: int, depth_kind: int) -> None:
    path = write(tmp_path / "a.sens", whole(color_kind, depth_kind))
    assert recognise(path) == "sens"
    sequence = pickle.loads(pickle.dumps(open_sequence(path)))
    assert (sequence.name, len(sequence), sequence.has_poses, sequence.depth_scale) == ("a", 4, True, 1000)
    np.testing.assert_array_equal(sequence.intrinsics.matrix, INTRINSIC[:3, :3])
    for i in (2, 0, 3, 1):
        frame = sequence[i]
        assert frame.stamp == pytest.approx(5 + 0.033333 * i, abs=1e-9)
        np.testing.assert_allclose(frame.depth, depth_of(i) / 1000, rtol=1e-6)
        np.testing.assert_array_equal(frame.pose, pose_of(i))
        assert np.abs(frame.rgb.astype(int) - colour(i)).max() <= (4 if color_kind == JPEG else 0)


def test_the_folder_of_a_scene_is_opened_as_its_file(tmp_path: Path) -> None:
    folder = write(tmp_path / "scene0000_00" / "scene0000_00.sens", whole()).parent
    (folder / "scene0000_00.txt").write_text("colorWidth = 8\n")
    assert recognise(folder) == "sens"
    assert open_sequence(folder).name == "scene0000_00"
    write(folder / "copy.sens", whole(frames=2))
    assert len(open_sequence(folder)) == 4
    write(tmp_path / "two" / "a.sens", whole())
    write(tmp_path / "two" / "b.sens", whole())
    with pytest.raises(BadInput, match="no known layout"):
        open_sequence(tmp_path / "two")


def end_of_frame(i: int) -> int:
    return len(header()) + sum(len(frame_bytes(k)) for k in range(i + 1))


CUTS = {
    "at the end of a frame": (end_of_frame(1), 2),
    "in the pose of a frame": (end_of_frame(1) + 20, 2),
    "in the sizes of a frame": (end_of_frame(1) + 95, 2),
    "in the colour of a frame": (end_of_frame(1) + 100, 2),
    "one byte before the end of depth": (end_of_frame(2) - 1, 2),
    "in the last frame": (end_of_frame(3) - 1, 3),
    "in the first frame but one": (end_of_frame(0) + 1, 1),
}


@pytest.mark.parametrize("cut", CUTS)
def test_frames_before_the_cut_stay_usable_and_the_cut_is_said(tmp_path: Path, cut: str) -> None:
    at, there = CUTS[cut]
    sequence = open_sequence(write(tmp_path / "a.sens", whole()[:at]))
    for i in range(there):
        np.testing.assert_array_equal(sequence[i].rgb, colour(i))
        np.testing.assert_allclose(sequence[i].depth, depth_of(i) / 1000, rtol=1e-6)
    assert len(sequence) == there + 1
    with pytest.raises(UnusableFrame, match=f"a.sens is cut short: {there} of 4 frames are there"):
        sequence[there]
    with pytest.raises(IndexError):
        sequence[there + 1]
    with pytest.raises(UnusableFrame, match="cut short"):
        open_sequence(tmp_path / "a.sens", use_poses=False)[there]


def test_measurements_after_the_frames_may_be_cut(tmp_path: Path) -> None:
    assert len(open_sequence(write(tmp_path / "a.sens", whole()[: end_of_frame(3)]))) == 4


REFUSED = {
    "empty": (b"", "ends within its header"),
    "half a header": (header()[:100], "ends within its header"),
    "no frame": (whole()[: end_of_frame(0) - 1], "no whole frame of 4"),
    "another version": (header(version=3) + whole()[len(header()) :], r"no \.sens file of version 4 .*begins with 3"),
    "text": (b"this is some text and no recording", r"no \.sens file of version 4"),
    "endless name": (struct.pack("<IQ", 4, 2**62) + b"x" * 400, r"no \.sens file"),
    "unknown compression": (header(color_kind=7) + frame_bytes(0), "its header names no known compression"),
    "no depth scale": (header(shift=0.0) + frame_bytes(0), "its header names no known compression"),
    "nan depth scale": (header(shift=float("nan")) + frame_bytes(0), "its header names no known compression"),
    "closed depth code": (header(depth_kind=OCCI_USHORT) + frame_bytes(0), "closed occi_ushort code"),
    "zero focal length": (header(color=np.zeros((4, 4))) + frame_bytes(0), "focal lengths must be positive"),
    "bent extrinsic": (header(extrinsic=2 * IDENTITY) + frame_bytes(0), "extrinsic matrices are not rigid"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_file_that_cannot_be_used_is_one_line_with_its_name(tmp_path: Path, kind: str) -> None:
    data, message = REFUSED[kind]
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(write(tmp_path / "a.sens", data))
    assert str(caught.value).startswith(str(tmp_path / "a.sens"))
    assert "\n" not in str(caught.value)


def test_lost_poses_and_damaged_images_cost_their_frames_alone(tmp_path: Path) -> None:
    lost = np.full((4, 4), -np.inf)
    zero = np.diag([0.0, 0, 0, 1])
    frames = [frame_bytes(0), frame_bytes(1, pose=lost), frame_bytes(2, pose=zero), frame_bytes(3), frame_bytes(4)]
    bad_depth = frame_bytes(5)
    frames.append(bad_depth[:-8] + b"\xff" * 8)
    short = bytearray(frame_bytes(6, RAW, RAW_USHORT))
    frames.append(bytes(short))
    frames[4] = frames[4].replace(b"IEND", b"IENX")
    sequence = open_sequence(write(tmp_path / "a.sens", header(frames=7) + b"".join(frames)))
    reasons = {1: "not finite", 2: "rotation is zero", 4: "a.sens, colour of frame 4 is truncated"}
    reasons |= {5: "a.sens, depth of frame 5 is damaged", 6: "frame 6"}
    for i, reason in reasons.items():
        with pytest.raises(UnusableFrame, match=reason):
            sequence[i]
    assert [sequence[i].index for i in (0, 3)] == [0, 3]


def test_colour_is_looked_up_through_the_extrinsics(tmp_path: Path) -> None:
    # At 1 m and with a focal length of 10 pixels, 0.2 m between the cameras are 2 pixels.
    color, depth = IDENTITY.copy(), IDENTITY.copy()
    color[0, 3], depth[0, 3] = 5, 5.2
    metre = zlib.compress(np.full((HEIGHT, WIDTH), 1000, "<u2").tobytes())
    rgb = cv2.imencode(".png", colour(9)[..., ::-1])[1].tobytes()
    frame = IDENTITY.tobytes() + struct.pack("<QQQQ", 1, 1, len(rgb), len(metre)) + rgb + metre
    data = header(frames=1, extrinsic=depth, color_extrinsic=color) + frame
    seen = open_sequence(write(tmp_path / "a.sens", data))[0].rgb
    np.testing.assert_array_equal(seen[:, :-2], colour(9)[:, 2:])
    assert not seen[:, -2:].any()


def test_a_file_without_any_pose_has_none(tmp_path: Path) -> None:
    lost = np.full((4, 4), -np.inf)
    data = header(frames=2) + frame_bytes(0, pose=lost) + frame_bytes(1, pose=lost)
    sequence = open_sequence(write(tmp_path / "a.sens", data))
    assert (sequence.has_poses, sequence[1].world_from_camera) == (False, None)


def test_stamps_that_stand_still_are_replaced_by_the_frame_rate(tmp_path: Path) -> None:
    frames = b"".join(frame_bytes(i, stamp_us=9) for i in range(3))
    sequence = open_sequence(write(tmp_path / "a.sens", header(frames=3) + frames))
    assert [sequence[i].stamp for i in range(3)] == pytest.approx([0, 1 / 30, 2 / 30])


def test_what_is_written_can_be_read_by_the_description_alone(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 3, 64, 48)
    write_scannet(room, tmp_path / "scene0000_00", sens=True)
    data = (tmp_path / "scene0000_00" / "scene0000_00.sens").read_bytes()
    version, length = struct.unpack_from("<IQ", data)
    at = 12 + length
    matrices = np.frombuffer(data, "<f4", 64, at).reshape(4, 4, 4)
    np.testing.assert_allclose(matrices[0, :3, :3], room.intrinsics.matrix, rtol=1e-6)
    np.testing.assert_array_equal(matrices[1], np.eye(4))
    *kinds, shift, count = struct.unpack_from("<iiIIIIfQ", data, at + 256)
    assert (version, kinds, shift, count) == (4, [JPEG, ZLIB_USHORT, 64, 48, 64, 48], 1000, 3)
    at += 256 + struct.calcsize("<iiIIIIfQ")
    for i in range(3):
        pose = np.frombuffer(data, "<f4", 16, at).reshape(4, 4)
        np.testing.assert_allclose(pose, room[i].pose, atol=1e-6)
        color_us, depth_us, n_color, n_depth = struct.unpack_from("<QQQQ", data, at + 64)
        assert color_us == depth_us == round(i / FRAMES_PER_S * 1e6)
        at += 96 + n_color
        depth = np.frombuffer(zlib.decompress(data[at : at + n_depth]), "<u2").reshape(48, 64)
        np.testing.assert_array_equal(depth, np.rint(room[i].depth * 1000))
        at += n_depth
    assert data[at:] == struct.pack("<Q", 0)
