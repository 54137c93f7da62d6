"""ICL-NUIM in its TUM form: stamps that count frames, poses from 1 on, and a camera whose y axis points up."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from razer.geometry import back_project, is_rigid, project, transform_points
from tests.support.recordings import colour, depth, write_image

FX, FY, CX, CY = 481.2, -480.0, 319.5, 239.5  # as published
# The first poses of livingRoom0.gt.freiburg.
PUBLISHED = """1 0 0 -2.25 0 0 0 1
2 0.000466347 0.00895357 -2.24935 -0.00101358 0.00052453 -0.000231475 0.999999
3 -0.000154972 -0.000102997 -2.25066 -0.00465149 0.000380752 0.000400181 0.999989
"""
SIZE = (640, 480)


def write_icl(folder: Path, truth: str = PUBLISHED, name: str = "livingRoom0.gt.freiburg", frames: int = 4) -> Path:
    for i in range(frames):
        write_image(folder / "rgb" / f"{i}.png", colour(i, *SIZE))
        write_image(folder / "depth" / f"{i}.png", depth(5000 + i, *SIZE))
    lines = [f"{i} depth/{i}.png {i} rgb/{i}.png" for i in range(frames)]
    (folder / "associations.txt").write_text("\n".join(lines) + "\n")
    (folder / name).write_text(truth)
    return folder


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_icl(tmp_path_factory.mktemp("living_room_traj0_frei_png"))


def test_frames_and_poses_share_their_count(published: Path) -> None:
    assert recognise(published) == "icl-nuim"
    sequence = open_sequence(published)
    assert (len(sequence), sequence.depth_scale) == (4, 5000)
    assert sequence.intrinsics == Intrinsics(640, 480, 481.2, 480, 319.5, 239.5)
    with pytest.raises(UnusableFrame, match="no pose at 0"):
        sequence[0]
    frame = pickle.loads(pickle.dumps(sequence))[1]
    assert (frame.rgb[0, 0, 0], frame.stamp) == (1, 1 / 30)
    assert frame.depth[0, 0] == np.float32(5001 / 5000)
    np.testing.assert_allclose(frame.pose[:3, 3], [0, 0, -2.25])


def test_mirrored_poses_put_every_pixel_where_the_published_camera_puts_it(tmp_path: Path) -> None:
    """A literal reading of the dataset: K with fy = -480 and the pose as written give left-handed world points;
    ours must be those points with y turned over, for all pixels and a strongly turned camera."""
    turn = Rotation.from_euler("xyz", [20, -35, 50], degrees=True)
    place = np.array([0.4, -1.2, 0.7])
    row = " ".join(map(str, [2, *place, *turn.as_quat()]))
    sequence = open_sequence(write_icl(tmp_path, truth=f"1 0 0 0 0 0 0 1\n{row}\n", name="traj0.gt.freiburg"))
    frame = sequence[2]
    assert is_rigid(frame.pose)
    rng = np.random.default_rng(0)
    u, v, z = rng.uniform(0, 639, 50), rng.uniform(0, 479, 50), rng.uniform(0.5, 4, 50)
    theirs = turn.apply(np.stack([(u - CX) / FX * z, (v - CY) / FY * z, z], axis=1)) + place
    ours = transform_points(frame.pose, back_project(u, v, z, frame.intrinsics.matrix))
    np.testing.assert_allclose(ours, theirs * [1, -1, 1], atol=1e-9)


def test_a_wall_seen_from_two_poses_falls_together(tmp_path: Path) -> None:
    """With y left as it is in the file, the second view would miss by several pixels."""
    tilt = Rotation.from_euler("x", 8, degrees=True)
    rows = [" ".join(map(str, [n, 0, 0.1 * n, 0, *(tilt**n).as_quat()])) for n in (1, 2)]
    sequence = open_sequence(write_icl(tmp_path, truth="\n".join(rows) + "\n"))
    first, second = sequence[1], sequence[2]
    point_lh = np.array([0.2, 0.4, 3.0])  # in the dataset's own world, y up
    pixels = []
    for n, frame in ((1, first), (2, second)):
        own = (tilt**n).inv().apply(point_lh - [0, 0.1 * n, 0])
        pixels.append((FX * own[0] / own[2] + CX, FY * own[1] / own[2] + CY))
        in_camera = np.linalg.inv(frame.pose) @ [0.2, -0.4, 3.0, 1]
        u, v, _ = project(in_camera[:3], frame.intrinsics.matrix)
        np.testing.assert_allclose((u, v), pixels[-1], atol=1e-9)
    assert abs(pixels[0][1] - pixels[1][1]) > 5


def test_without_associations_names_pair(tmp_path: Path) -> None:
    write_icl(tmp_path)
    (tmp_path / "associations.txt").unlink()
    (tmp_path / "rgb" / "2.png").unlink()
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"rgb/2\.png is missing"):
        sequence[2]
    assert sequence[3].rgb[0, 0, 0] == 3


def test_an_associated_file_that_is_absent_costs_its_frame_alone(tmp_path: Path) -> None:
    write_icl(tmp_path)
    (tmp_path / "depth" / "2.png").unlink()
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"depth/2\.png is missing"):
        sequence[2]
    assert sequence[1].pose[2, 3] == -2.25


def test_faults_are_one_line(tmp_path: Path) -> None:
    truth = PUBLISHED.replace("2 0.000466347", "2 nan").replace("0.999989\n", "0.5\n")
    write_icl(tmp_path, truth=truth + "4 0.1 0.")
    sequence = open_sequence(tmp_path)
    assert sequence[1].pose[2, 3] == -2.25
    for index, reason in ((2, "not finite"), (3, "has length")):
        with pytest.raises(UnusableFrame, match=reason):
            sequence[index]
    (tmp_path / "associations.txt").write_text("0 depth/0.png rgb/0.png\n")
    with pytest.raises(BadInput, match=r"associations\.txt, line 1"):
        open_sequence(tmp_path)
