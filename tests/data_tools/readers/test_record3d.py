"""Record3D's exports: the .r3d archive and the folder of JPEG and EXR images."""

from __future__ import annotations

import json
import pickle
import sys
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from razer.geometry import back_project, transform_points
from tests.support.recordings import depth, write_image

COLOR_SIZE, DEPTH_SIZE = (24, 32), (6, 8)  # upright, as a phone is held
FRAMES = 3
TURN = Rotation.from_euler("y", 30, degrees=True)


def metadata(**more: Any) -> dict[str, Any]:
    """K column by column: fx 20, fy 21, cx 11.5, cy 15.5 in pixels of colour."""
    quaternions = [list((TURN**i).as_quat()) for i in range(FRAMES)]
    return {
        "w": COLOR_SIZE[0],
        "h": COLOR_SIZE[1],
        "dw": DEPTH_SIZE[0],
        "dh": DEPTH_SIZE[1],
        "fps": 30,
        "K": [20.0, 0, 0, 0, 21.0, 0, 11.5, 15.5, 1],
        "poses": [[*quaternion, i, 1.5, -i] for i, quaternion in enumerate(quaternions)],
        "frameTimestamps": [5.0, 5.04, 5.08],
        **more,
    }


def jpeg(value: int) -> bytes:
    image = np.full((COLOR_SIZE[1], COLOR_SIZE[0], 3), value, np.uint8)
    return cv2.imencode(".jpg", image)[1].tobytes()


def metres(i: int) -> np.ndarray:
    """1 + i / 4 metres, deeper to the right; one pixel unknown."""
    values = np.full((DEPTH_SIZE[1], DEPTH_SIZE[0]), 1 + i / 4, np.float32) + np.arange(DEPTH_SIZE[0]) / 8
    values[0, 0] = np.nan
    return values.astype(np.float32)


def members(told: dict[str, Any] | None = None) -> dict[str, bytes]:
    lzfse = pytest.importorskip("liblzfse")
    found = {"metadata": json.dumps(metadata() if told is None else told).encode(), "icon": jpeg(0)}
    for i in range(FRAMES):
        confidence = np.full(DEPTH_SIZE[::-1], 2, np.uint8)
        confidence[1, :2] = 0, 1
        found[f"rgbd/{i}.jpg"] = jpeg(50 * (i + 1))
        found[f"rgbd/{i}.depth"] = lzfse.compress(metres(i).tobytes())
        found[f"rgbd/{i}.conf"] = lzfse.compress(confidence.tobytes())
    return found


def write_r3d(path: Path, content: dict[str, bytes]) -> Path:
    with ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return path


def write_exr_folder(folder: Path, told: dict[str, Any] | None = None) -> Path:
    exr = pytest.importorskip("OpenEXR")
    (folder / "rgb").mkdir(parents=True)
    (folder / "depth").mkdir()
    (folder / "metadata.json").write_text(json.dumps(metadata() if told is None else told))
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    for i in range(FRAMES):
        (folder / "rgb" / f"{i}.jpg").write_bytes(jpeg(50 * (i + 1)))
        exr.File(header, {"R": metres(i)}).write(str(folder / "depth" / f"{i}.exr"))
    return folder


def unpack(path: Path) -> Path:
    with ZipFile(path) as archive:
        archive.extractall(path.with_suffix(""))
    return path.with_suffix("")


@pytest.fixture(params=["archive", "unpacked archive", "exr folder"])
def export(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    if request.param == "exr folder":
        return write_exr_folder(tmp_path / "scan" / "EXR_RGBD")
    archive = write_r3d(tmp_path / "scan.r3d", members())
    return archive if request.param == "archive" else unpack(archive)


def test_frames_lie_on_the_grid_of_depth(export: Path) -> None:
    assert recognise(export) == "record3d"
    sequence = pickle.loads(pickle.dumps(open_sequence(export)))
    assert (len(sequence), sequence.has_poses) == (FRAMES, True)
    assert sequence.intrinsics == Intrinsics(24, 32, 20, 21, 11.5, 15.5).resized(*DEPTH_SIZE)
    for i in (2, 0, 1):
        frame = sequence[i]
        assert frame.stamp == 5 + i / 25
        np.testing.assert_allclose(frame.rgb, 50 * (i + 1), atol=2)
        known = frame.depth > 0
        np.testing.assert_allclose(frame.depth[known], metres(i)[known], atol=1e-6)
        assert not known[0, 0]
        assert known.sum() >= known.size - 2


def test_metadata_of_another_program_is_not_taken_for_an_export(tmp_path: Path) -> None:
    for part, image in (("rgb", np.zeros((6, 8, 3), np.uint8)), ("depth", depth(1500))):
        write_image(tmp_path / part / "0.png", image)
    (tmp_path / "metadata.json").write_text('{"author": "somebody", "poses": 12}')
    assert recognise(tmp_path) == "folder"


def test_depth_of_the_lowest_confidence_is_left_out(tmp_path: Path) -> None:
    frame = open_sequence(write_r3d(tmp_path / "a.r3d", members()))[0]
    assert (frame.depth[1, 0], frame.depth[1, 1]) == (0, 1.125)


def test_poses_are_turned_from_arkit_to_opencv_axes(export: Path) -> None:
    """ARKit: x right, y up, the camera looks along its -z; a point ahead, left and up of it stays where it is."""
    frame = open_sequence(export)[1]
    in_arkit_camera = np.array([-0.3, 0.2, -2.0])
    expected = TURN.apply(in_arkit_camera) + np.array([1, 1.5, -1])
    matrix = frame.intrinsics.matrix
    u, v = matrix[0, 0] * -0.3 / 2 + matrix[0, 2], matrix[1, 1] * -0.2 / 2 + matrix[1, 2]
    point = back_project(np.array([u]), np.array([v]), np.array([2.0]), matrix)
    np.testing.assert_allclose(transform_points(frame.pose, point)[0], expected, atol=1e-9)


def test_a_moving_lens_gives_the_camera_in_the_middle(tmp_path: Path) -> None:
    coefficients = [[19.0, 20, 11.5, 15.5], [20.4, 21.4, 11.5, 15.5], [20.2, 21.2, 11.5, 15.5]]
    told = metadata(perFrameIntrinsicCoeffs=coefficients)
    sequence = open_sequence(write_r3d(tmp_path / "a.r3d", members(told)))
    assert sequence.intrinsics.fx == pytest.approx(20.2 / 4)


def test_an_old_export_says_neither_stamps_nor_depth_size(tmp_path: Path) -> None:
    told = {key: value for key, value in metadata().items() if key not in ("frameTimestamps", "dw", "dh")}
    content = members(told)
    lzfse = pytest.importorskip("liblzfse")
    for i in range(FRAMES):
        content[f"rgbd/{i}.depth"] = lzfse.compress(np.full(192 * 256, 1 + i, np.float32).tobytes())
    sequence = open_sequence(write_r3d(tmp_path / "a.r3d", content))
    assert (sequence.intrinsics.width, sequence.intrinsics.height) == (192, 256)
    assert sequence[2].stamp == pytest.approx(2 / 30)


def test_depth_as_16_bit_png_is_in_millimetres(tmp_path: Path) -> None:
    (tmp_path / "rgb").mkdir()
    (tmp_path / "metadata.json").write_text(json.dumps(metadata()))
    for i in range(FRAMES):
        (tmp_path / "rgb" / f"{i}.jpg").write_bytes(jpeg(50))
        write_image(tmp_path / "depth" / f"{i}.png", depth(1500, *DEPTH_SIZE))
    assert open_sequence(tmp_path)[1].depth[0, 0] == 1.5


FRAME_FAULTS: dict[str, tuple[dict[str, bytes | None], str]] = {
    "no depth": ({"rgbd/1.depth": None}, r"rgbd/1\.depth is missing"),
    "no colour": ({"rgbd/1.jpg": None}, r"rgbd/1\.jpg is missing"),
    "damaged depth": ({"rgbd/1.depth": b"bvx2 and no more"}, r"rgbd/1\.depth is damaged"),
    "empty colour": ({"rgbd/1.jpg": b""}, r"rgbd/1\.jpg is empty"),
    "truncated colour": ({"rgbd/1.jpg": jpeg(9)[:-30]}, r"rgbd/1\.jpg is truncated"),
}


@pytest.mark.parametrize("fault", FRAME_FAULTS)
def test_a_damaged_frame_costs_itself_alone(tmp_path: Path, fault: str) -> None:
    changes, reason = FRAME_FAULTS[fault]
    content = {name: data for name, data in (members() | changes).items() if data is not None}
    sequence = open_sequence(write_r3d(tmp_path / "a.r3d", content))
    assert len(sequence) == FRAMES
    with pytest.raises(UnusableFrame, match=reason):
        sequence[1]
    assert sequence[2].stamp == 5.08


@pytest.mark.parametrize(
    "row", [[0] * 7, [0, 0, 0, 1, float("nan"), 0, 0], [0, 0, 0, 1, 0, 0, float("-inf")], [0, 0, 0]]
)
def test_a_bad_pose_costs_its_frame_alone(tmp_path: Path, row: list[float]) -> None:
    told = metadata()
    told["poses"][1] = row
    sequence = open_sequence(write_r3d(tmp_path / "a.r3d", members(told)))
    with pytest.raises(UnusableFrame, match="pose 1: "):
        sequence[1]
    assert sequence[2].pose[0, 3] == 2


def test_fewer_poses_than_frames_leave_the_last_without(tmp_path: Path) -> None:
    sequence = open_sequence(write_r3d(tmp_path / "a.r3d", members(metadata(poses=metadata()["poses"][:2]))))
    assert sequence[1].pose[0, 3] == 1
    with pytest.raises(UnusableFrame, match="pose 2"):
        sequence[2]


def test_a_truncated_exr_costs_its_frame_alone(tmp_path: Path) -> None:
    folder = write_exr_folder(tmp_path / "a")
    path = folder / "depth" / "1.exr"
    path.write_bytes(path.read_bytes()[:-20])
    sequence = open_sequence(folder)
    with pytest.raises(UnusableFrame, match=r"depth/1\.exr is damaged or truncated"):
        sequence[1]
    assert sequence[0].depth.any()


def test_what_cannot_be_opened_is_one_line(tmp_path: Path) -> None:
    cut = write_r3d(tmp_path / "cut.r3d", members())
    cut.write_bytes(cut.read_bytes()[:-300])
    bare = write_r3d(tmp_path / "bare.r3d", members({"w": 24}))
    for path, message in ((cut, "no whole .r3d archive"), (bare, "not that of a Record3D export")):
        with pytest.raises(BadInput, match=message) as caught:
            open_sequence(path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("module", "package"), [("liblzfse", "pyliblzfse"), ("OpenEXR", "OpenEXR")])
def test_without_the_package_the_fix_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, package: str
) -> None:
    archive, folder = write_r3d(tmp_path / "a.r3d", members()), write_exr_folder(tmp_path / "b")
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BadInput, match=rf"{package}: pip install 'razer\[record3d\]'"):
        open_sequence(archive if module == "liblzfse" else folder)
