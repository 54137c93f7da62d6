"""Plain folders whose colour and depth come at different rates or under different names."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_tools import open_sequence
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput, UnusableFrame
from tests.support.recordings import colour, depth, write_image, write_tum

CAMERA = "10,10,3.5,2.5"


def write_names(folder: Path, colors: list[str], depths: list[str]) -> Path:
    """The i-th colour image has red = i, the i-th depth image 1000 + i units."""
    for i, name in enumerate(colors):
        write_image(folder / "color" / f"{name}.png", colour(i))
    for i, name in enumerate(depths):
        write_image(folder / "depth" / f"{name}.png", depth(1000 + i))
    return folder


def pairs(sequence: RgbdSequence) -> list[tuple[int, int]]:
    """(colour, depth) by their place in the recording, of each frame."""
    frames = [sequence[i] for i in range(len(sequence))]
    return [(int(f.rgb[0, 0, 0]), round(float(f.depth[0, 0]) * 1000) - 1000) for f in frames]


def test_lists_of_stamps_pair_streams_of_different_rate(tmp_path: Path) -> None:
    write_names(tmp_path, [str(i) for i in range(12)], [str(i) for i in range(5)])
    (tmp_path / "stamps_color.txt").write_text("".join(f"{10 + i / 30:.6f}\n" for i in range(12)))
    (tmp_path / "stamps_depth.txt").write_text("".join(f"{10.005 + i / 12.5:.6f}\n" for i in range(5)))
    sequence = open_sequence(tmp_path, camera=CAMERA)
    assert pairs(sequence) == [(0, 0), (3, 1), (5, 2), (7, 3), (10, 4)]
    assert [sequence[i].stamp for i in range(5)] == pytest.approx([10.005 + i / 12.5 for i in range(5)])


@pytest.mark.parametrize("units", ["seconds", "milliseconds", "microseconds", "nanoseconds"])
def test_names_that_are_stamps_pair_by_time_and_find_poses_between(tmp_path: Path, units: str) -> None:
    digits = {"milliseconds": 3, "microseconds": 6, "nanoseconds": 9}
    start, steps = 1305031102, (0, 33, 67, 100, 133)

    def name(milliseconds: int) -> str:
        if units == "seconds":
            return f"{start}.{milliseconds:03d}000"
        return f"{start}{milliseconds:03d}" + "0" * (digits[units] - 3)

    write_names(tmp_path, [name(ms) for ms in steps], [name(ms) for ms in (8, 70, 128)])
    (tmp_path / "trajectory.txt").write_text(
        "".join(f"{start}.{ms:03d} {ms} 0 0 0 0 0 1\n" for ms in (0, 50, 100, 150))
    )
    sequence = open_sequence(tmp_path, camera=CAMERA)
    assert pairs(sequence) == [(0, 0), (2, 1), (4, 2)]
    assert [sequence[i].pose[0, 3] for i in range(3)] == pytest.approx([8, 70, 128], abs=1e-3)


def test_every_second_number_is_another_rate_and_not_a_loss(tmp_path: Path) -> None:
    write_names(tmp_path, [f"{i:04d}" for i in range(8)], [f"d{i:04d}" for i in range(0, 8, 2)])
    assert pairs(open_sequence(tmp_path, camera=CAMERA)) == [(0, 0), (2, 1), (4, 2), (6, 3)]
    sparse = write_names(tmp_path / "b", [f"{i}" for i in range(0, 13, 3)], [f"{i}" for i in range(0, 13, 2)])
    found = pairs(open_sequence(sparse, camera=CAMERA))
    for color, deep in found:
        assert abs(3 * color - 2 * deep) <= 1
    assert len(found) == 5
    assert len({deep for _, deep in found}) == 5


def test_a_lost_image_at_the_same_rate_is_a_bad_frame(tmp_path: Path) -> None:
    names = [f"{i:04d}" for i in range(8)]
    sequence = open_sequence(write_names(tmp_path, names, [n for n in names if n != "0003"]), camera=CAMERA)
    assert len(sequence) == 8
    with pytest.raises(UnusableFrame, match=r"depth/0003\.png is missing"):
        sequence[3]


FAULTS = {
    "too few stamps": ("0\n1\n", "stamps_color.txt has 2 stamps for 3 images"),
    "no numbers": ("a\nb\nc\n", "stamps_color.txt must hold one number"),
    "another clock": ("100\n101\n102\n", "within 0.02 s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_stamps_that_do_not_fit_are_one_line(tmp_path: Path, fault: str) -> None:
    text, message = FAULTS[fault]
    write_names(tmp_path, list("012"), list("012"))
    (tmp_path / "stamps_color.txt").write_text(text)
    (tmp_path / "stamps_depth.txt").write_text("0\n1\n2\n")
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(tmp_path, camera=CAMERA)
    assert "\n" not in str(caught.value)


def test_images_that_a_tum_list_names_but_that_are_absent_cost_their_frames_alone(tmp_path: Path) -> None:
    stamps = [1.0, 1.04, 1.08, 1.12]
    write_tum(tmp_path, stamps, stamps, "".join(f"{s} {s} 0 0 0 0 0 1\n" for s in stamps) + "1.16 0.3 0")
    (tmp_path / "depth" / "1.png").unlink()
    (tmp_path / "rgb" / "2.png").unlink()
    sequence = open_sequence(tmp_path)
    assert [sequence[i].pose[0, 3] for i in (0, 3)] == [1.0, 1.12]
    for index, name in ((1, "depth/1.png"), (2, "rgb/2.png")):
        with pytest.raises(UnusableFrame, match=f"{name} is missing"):
            sequence[index]


def test_a_stamp_that_is_nan_gives_no_frame_its_pose(tmp_path: Path) -> None:
    write_tum(tmp_path, [1.0, 1.04], [1.0, 1.04], "1.0 1 0 0 0 0 0 1\nnan 9 0 0 0 0 0 1\n1.04 -inf 0 0 0 0 0 1\n")
    sequence = open_sequence(tmp_path)
    assert sequence[0].pose[0, 3] == 1
    with pytest.raises(UnusableFrame, match="not finite"):
        sequence[1]
