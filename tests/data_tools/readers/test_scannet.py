"""Extracted scenes of ScanNet: two cameras, lost poses, and the ways in which people lay the files out."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.readers.scannet.extracted import is_scannet
from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.scannet import write_scannet
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from tests.support.recordings import depth, write_image

# An eighth of ScanNet's 640x480 and 1296x968, with the cameras of its documentation.
DEPTH_SIZE, COLOR_SIZE = (80, 60), (162, 121)
DEPTH_CAMERA = Intrinsics(640, 480, 571.62, 571.62, 319.5, 239.5).resized(*DEPTH_SIZE)
FULL_COLOR_CAMERA = Intrinsics(1296, 968, 1170.19, 1170.19, 647.75, 483.75)
COLOR_CAMERA = FULL_COLOR_CAMERA.resized(*COLOR_SIZE)
WALL_M = 2.0


def painted(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The colours of a wall at its points, metres: steep enough to tell pixels apart."""
    return np.stack([128 + 100 * x, 128 + 120 * y, 128 + 60 * (x - y)], axis=-1).clip(0, 255).round().astype(np.uint8)


def wall_seen_by(camera: Intrinsics, color_from_depth: np.ndarray) -> np.ndarray:
    """The wall z = WALL_M of the depth camera as the colour camera sees it, ray by ray."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], axis=-1)
    depth_from_color = np.linalg.inv(color_from_depth)
    start, rays = depth_from_color[:3, 3], rays @ depth_from_color[:3, :3].T
    points = start + rays * ((WALL_M - start[2]) / rays[..., 2])[..., None]
    return painted(points[..., 0], points[..., 1])


def matrix4(camera: Intrinsics) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = camera.matrix
    return matrix


def write_wall(
    folder: Path,
    extrinsic: np.ndarray | None = None,
    seen_by: Intrinsics = COLOR_CAMERA,
    told: Intrinsics = COLOR_CAMERA,
    names: tuple[str, ...] = ("0", "1"),
) -> Path:
    """A wall in front of two cameras; extrinsic takes points of the depth camera to the base, the colour camera."""
    extrinsic = np.eye(4) if extrinsic is None else extrinsic
    for name in names:
        write_image(folder / "color" / f"{name}.png", wall_seen_by(seen_by, extrinsic))
        write_image(folder / "depth" / f"{name}.png", depth(round(WALL_M * 1000), *DEPTH_SIZE))
        (folder / "pose").mkdir(exist_ok=True)
        np.savetxt(folder / "pose" / f"{name}.txt", np.eye(4), fmt="%f")
    (folder / "intrinsic").mkdir()
    for kind, camera in (("color", told), ("depth", DEPTH_CAMERA)):
        np.savetxt(folder / "intrinsic" / f"intrinsic_{kind}.txt", matrix4(camera), fmt="%f")
    np.savetxt(folder / "intrinsic" / "extrinsic_color.txt", np.eye(4), fmt="%f")
    np.savetxt(folder / "intrinsic" / "extrinsic_depth.txt", extrinsic, fmt="%f")
    return folder


def assert_colors_lie_on_depth(frame: Frame) -> None:
    """Every pixel has the colour of the point at its depth, wherever the colour camera looks."""
    v, u = np.mgrid[4 : DEPTH_SIZE[1] - 4, 4 : DEPTH_SIZE[0] - 4]
    x, y = (np.array([u - frame.intrinsics.cx, v - frame.intrinsics.cy]) / frame.intrinsics.fx) * WALL_M
    difference = np.abs(frame.rgb[4:-4, 4:-4].astype(int) - painted(x, y))
    assert difference.max() <= 3


def test_colour_of_1296x968_lies_on_depth_of_640x480(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "scene0000_00")
    sequence = open_sequence(folder)
    assert (recognise(folder), len(sequence), sequence.has_poses) == ("scannet", 2, True)
    np.testing.assert_allclose(sequence.intrinsics.matrix, DEPTH_CAMERA.matrix, atol=1e-5)
    frame = pickle.loads(pickle.dumps(sequence))[1]
    assert frame.stamp == pytest.approx(1 / 30)
    np.testing.assert_array_equal(frame.depth, np.full(DEPTH_SIZE[::-1], WALL_M, np.float32))
    assert_colors_lie_on_depth(frame)


def test_the_extrinsic_of_depth_leads_to_the_colour_camera(tmp_path: Path) -> None:
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_euler("xyz", [1.5, -2, 1], degrees=True).as_matrix()
    moved[:3, 3] = 0.05, 0.02, -0.03
    assert_colors_lie_on_depth(open_sequence(write_wall(tmp_path / "a", moved))[0])
    # Both may lead to a base that is neither camera: only what lies between them counts.
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = Rotation.from_euler("y", 30, degrees=True).as_matrix(), (1, 2, 3)
    np.savetxt(tmp_path / "a" / "intrinsic" / "extrinsic_color.txt", base)
    np.savetxt(tmp_path / "a" / "intrinsic" / "extrinsic_depth.txt", base @ moved)
    assert_colors_lie_on_depth(open_sequence(tmp_path / "a")[0])
    np.savetxt(tmp_path / "a" / "intrinsic" / "extrinsic_color.txt", np.eye(4))
    # The test can fail: the inverse, or no extrinsic at all, puts colours elsewhere.
    for wrong in (np.linalg.inv(moved), np.eye(4)):
        np.savetxt(tmp_path / "a" / "intrinsic" / "extrinsic_depth.txt", wrong)
        with pytest.raises(AssertionError):
            assert_colors_lie_on_depth(open_sequence(tmp_path / "a")[0])


def test_colour_extracted_smaller_keeps_the_matrix_of_the_full_image(tmp_path: Path) -> None:
    small = FULL_COLOR_CAMERA.resized(*DEPTH_SIZE)
    folder = write_wall(tmp_path / "a", seen_by=small, told=FULL_COLOR_CAMERA)
    assert_colors_lie_on_depth(open_sequence(folder)[0])


def test_the_preview_of_25k_frames_and_frames_in_a_folder_of_their_own(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "scene0001_00", names=("000000", "000100"))
    for kind in ("color", "depth"):
        (folder / "intrinsic" / f"intrinsic_{kind}.txt").rename(folder / f"intrinsics_{kind}.txt")
    for path in (folder / "intrinsic").iterdir():
        path.unlink()
    sequence = open_sequence(folder)
    assert (recognise(folder), len(sequence)) == ("scannet", 2)
    assert sequence[1].stamp == pytest.approx(100 / 30)
    assert_colors_lie_on_depth(sequence[1])
    write_wall(tmp_path / "scene0002_00" / "frames")
    assert recognise(tmp_path / "scene0002_00") == "scannet"
    assert open_sequence(tmp_path / "scene0002_00").name == "scene0002_00"


LOST = {
    "-inf": (np.full((4, 4), -np.inf), "not finite"),
    "nan": (np.full((4, 4), np.nan), "not finite"),
    "zero rotation": (np.diag([0.0, 0, 0, 1]), "rotation is zero"),
    "sheared": (np.diag([1.0, 1.3, 1, 1]), "not orthonormal"),
}


@pytest.mark.parametrize("kind", LOST)
def test_a_lost_pose_costs_its_frame_alone(tmp_path: Path, kind: str) -> None:
    pose, reason = LOST[kind]
    folder = write_wall(tmp_path / "a", names=("0", "1", "2"))
    np.savetxt(folder / "pose" / "1.txt", pose, fmt="%f")
    sequence = open_sequence(folder)
    with pytest.raises(UnusableFrame, match=rf"pose/1\.txt: the .*{reason}"):
        sequence[1]
    assert [sequence[i].index for i in (0, 2)] == [0, 2]
    assert open_sequence(folder, use_poses=False)[1].world_from_camera is None


def test_missing_files_cost_their_frames_alone(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "a", names=("0", "1", "2", "3"))
    for gone in ("color/0.png", "depth/1.png", "pose/2.txt"):
        (folder / gone).unlink()
    sequence = open_sequence(folder)
    for i, name in enumerate(("color/0.jpg", "depth/1.png", "pose/2.txt")):
        with pytest.raises(UnusableFrame, match=f"{name} is missing"):
            sequence[i]
    assert_colors_lie_on_depth(sequence[3])


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("intrinsic_depth.txt", "1 2 3\n", r"intrinsic_depth\.txt must hold a 4x4 matrix"),
        ("intrinsic_color.txt", "", r"intrinsic_color\.txt must hold a 4x4 matrix"),
        ("intrinsic_color.txt", "-" + "1 0 0 0\n" * 4, "focal lengths must be positive"),
        ("extrinsic_depth.txt", "2 0 0 0\n" * 4, r"extrinsic_depth\.txt must hold a rigid 4x4 matrix"),
    ],
)
@pytest.mark.filterwarnings("ignore:loadtxt")
def test_a_damaged_matrix_is_one_line(tmp_path: Path, name: str, text: str, message: str) -> None:
    folder = write_wall(tmp_path / "a")
    (folder / "intrinsic" / name).write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(folder)
    assert "\n" not in str(caught.value)


def test_a_declared_camera_overrides_the_files(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "a", seen_by=COLOR_CAMERA.resized(*DEPTH_SIZE))
    (folder / "intrinsic" / "intrinsic_color.txt").write_text("nonsense")
    assert open_sequence(folder, camera="70,71,39,29").intrinsics.fy == 71


def test_a_plain_folder_is_none_of_scannet(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "a")
    (folder / "intrinsic" / "intrinsic_depth.txt").unlink()
    assert not is_scannet(folder)
    assert recognise(folder) == "folder"


def test_what_is_written_is_named_and_scaled_as_sensreader_does(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    write_scannet(room, tmp_path / "scene0009_00")
    folder = tmp_path / "scene0009_00"
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    matrices = {f"intrinsic/{part}_{kind}.txt" for part in ("intrinsic", "extrinsic") for kind in ("color", "depth")}
    frames = {f"{part}/{i}.{suffix}" for part, suffix in FRAME_FILES.items() for i in (0, 1)}
    assert files == {*matrices, *frames, "scene0009_00.txt"}
    np.testing.assert_allclose(np.loadtxt(folder / "pose" / "1.txt"), room[1].pose, atol=1e-8)
    np.testing.assert_allclose(
        np.loadtxt(folder / "intrinsic" / "intrinsic_color.txt"), matrix4(room.intrinsics), rtol=1e-8
    )
    told = dict(line.split(" = ") for line in (folder / "scene0009_00.txt").read_text().splitlines())
    assert (told["colorWidth"], told["depthHeight"], told["numDepthFrames"]) == ("64", "48", "2")
    assert float(told["fx_depth"]) == pytest.approx(room.intrinsics.fx, abs=1e-6)


FRAME_FILES = {"color": "jpg", "depth": "png", "pose": "txt"}


@pytest.mark.parametrize("sens", [False, True])
def test_a_frame_without_pose_is_written_as_lost(tmp_path: Path, sens: bool) -> None:
    class PartlyLost(SyntheticRoom):
        def __getitem__(self, index: int) -> Frame:
            frame = super().__getitem__(index)
            kept = frame.world_from_camera if index else None
            return Frame(index, frame.stamp, frame.rgb, frame.depth, frame.intrinsics, kept)

    write_scannet(PartlyLost(0, 2, 64, 48), tmp_path / "a", sens=sens)
    assert sens or np.isneginf(np.loadtxt(tmp_path / "a" / "pose" / "0.txt")).all()
    sequence = open_sequence(tmp_path / "a")
    with pytest.raises(UnusableFrame, match="not finite"):
        sequence[0]
    assert sequence[1].world_from_camera is not None
