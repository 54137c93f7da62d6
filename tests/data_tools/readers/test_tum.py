"""TUM RGB-D: association by time, interpolated poses, cameras by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from data_tools.readers.tum import CAMERAS, associate
from data_tools.registry import open_sequence
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from tests.support.recordings import HEIGHT, WIDTH, write_tum

TRUTH = "".join(f"{stamp} {stamp} 0 0 0 0 0 1\n" for stamp in (0.95, 1.0, 1.05, 1.10, 1.15))


def test_stamps_are_associated_nearest_first_each_used_once() -> None:
    a = np.array([1.00, 1.03, 1.06, 2.0])
    b = np.array([1.061, 1.014, 1.029, 2.0201])
    # 1.03 takes 1.029 (1 ms) although 1.00 has no other partner but 1.014; 2.0 is 20.1 ms away.
    assert associate(a, b, 0.02) == [(0, 1), (1, 2), (2, 0)]


@pytest.mark.parametrize("seed", range(20))
def test_association_equals_the_slow_greedy_rule(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0, 0.5, 20), rng.uniform(0, 0.5, 25)
    gaps = np.abs(a[:, None] - b[None])
    expected = []
    while (best := gaps.min()) <= 0.02:
        i, j = np.argwhere(gaps == best)[0]
        expected.append((i, j))
        gaps[i, :] = gaps[:, j] = np.inf
    assert associate(a, b, 0.02) == sorted(expected, key=lambda pair: a[pair[0]])


def test_tum_frames_pair_colour_with_depth_and_interpolate_poses(tmp_path: Path) -> None:
    write_tum(tmp_path, [1.00, 1.04, 1.08, 1.20], [1.01, 1.045, 1.09, 1.30], TRUTH)
    sequence = open_sequence(tmp_path)
    assert (len(sequence), sequence.depth_scale) == (3, 5000)  # 1.20 and 1.30 find nobody
    assert sequence.intrinsics == CAMERAS["3"].at((8 * WIDTH, 8 * HEIGHT))  # "freiburg3" in a comment
    for i, stamp in enumerate((1.01, 1.045, 1.09)):
        frame = sequence[i]
        assert frame.stamp == stamp
        assert frame.rgb[0, 0, 0] == i
        assert frame.depth[0, 0] == np.float32((5000 + i) / 5000)
        np.testing.assert_allclose(frame.pose[:3, 3], [stamp, 0, 0], atol=1e-9)


def test_a_tum_frame_outside_the_ground_truth_has_no_usable_pose(tmp_path: Path) -> None:
    write_tum(tmp_path, [0.5, 1.0], [0.5, 1.0], TRUTH)
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"groundtruth\.txt does not cover 0\.5"):
        sequence[0]
    assert sequence[1].pose[0, 3] == 1.0


def test_the_tum_camera_is_unknown_without_a_hint(tmp_path: Path) -> None:
    write_tum(tmp_path, [1.0], [1.0])
    for name in ("rgb.txt", "depth.txt"):
        path = tmp_path / name
        path.write_text(path.read_text().replace("freiburg3", "attic"))
    with pytest.raises(BadInput, match="--intrinsics"):
        open_sequence(tmp_path)
    sequence = open_sequence(tmp_path, camera="9,9,3.5,2.5")
    assert (sequence.intrinsics.fx, sequence.has_poses) == (9, False)


def check_real_frame(frame: Frame) -> None:
    valid = frame.depth[frame.depth > 0]
    assert valid.size > 100_000
    assert 0.3 < np.median(valid) < 4
    assert frame.rgb.std() > 20


def test_tum(real_data: Path) -> None:
    sequence = open_sequence(real_data / "tum_fr1_rpy_head")
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (60, True, 5000)
    assert sequence.intrinsics == Intrinsics(640, 480, 517.3, 516.5, 318.6, 255.3)
    frame = sequence[0]
    check_real_frame(frame)
    assert frame.stamp == 1305031229.528784
    truth = np.loadtxt(real_data / "tum_fr1_rpy_head" / "groundtruth.txt")
    after = np.searchsorted(truth[:, 0], frame.stamp)
    ends = truth[after - 1 : after + 1, 1:4]
    assert (frame.pose[:3, 3] >= ends.min(axis=0) - 1e-9).all()
    assert (frame.pose[:3, 3] <= ends.max(axis=0) + 1e-9).all()
