"""What the timeline says first: what was left out, what may be mapped twice, how poses went; and clear names."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.render.viewpoint import Viewpoint, overview
from app.timeline.objects.clear_labels import clear_labels
from app.timeline.objects.lives_document import lives_document, pair_verdict
from app.timeline.objects.near_namesakes import near_namesakes
from app.timeline.poses.pose_verdict import pose_verdict
from app.timeline.summary import RunSummary, in_ranges
from razer.boxes.oriented_box import OrientedBox
from slam.se3 import exp_se3


def thing(number, name, x_m, *, stuff=False, first_frame=0):
    box = OrientedBox(np.array([x_m, 0.0, 0.0]), np.eye(3), np.full(3, 0.5))
    figures = {"observations": 3, "first_frame": first_frame, "last_frame": 9, "score": 0.5}
    return SimpleNamespace(id=number, class_name=name, box=box, is_stuff=stuff, **figures)


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ([7], "frame 7"),
        ([50, 51, 52], "frames 50-52"),
        ([4, 2, 3, 9], "frames 2-4, 9"),
        (range(0, 20, 2), "frames 0, 2, 4, 6, 8, 10, ..."),
    ],
)
def test_frames_are_told_as_ranges(frames, words):
    assert in_ranges(frames) == words


def test_what_was_left_out_is_told_by_reason_whatever_file_it_names():
    summary = RunSummary()
    for frame in range(5):
        summary.use(np.zeros(3))
        summary.leave_out(10 + frame, f"depth/{frame:06d}.png holds nothing")
    for frame in (15, 16, 20):
        summary.leave_out(frame, "lost: the camera could not be located")
    summary.find_late([0, 16, 99])
    assert summary.gaps() == [
        "**Left out: frames 10-14**, depth/000000.png holds nothing",
        "**Camera lost in frames 15-16, 20**; frame 16 located later",
    ]
    card = summary.markdown(2, 1, ["a verdict"])
    assert card.index("Left out") < card.index("a verdict") < card.index("frames mapped")


def test_a_run_without_gaps_has_no_line_of_them():
    assert RunSummary().gaps() == []


def test_pairs_are_of_one_name_and_overlap_and_the_worst_comes_first():
    items = [
        thing(1, "chair", 0.0),
        thing(2, "chair", 0.1, first_frame=5),
        thing(3, "chair", 0.42, first_frame=6),  # overlaps the first by a sixth, the second by a third
        thing(4, "table", 0.0),
        thing(5, None, 0.0),
        thing(6, None, 0.0),
        thing(7, "wall", 0.0, stuff=True),
        thing(8, "wall", 0.0, stuff=True),
        thing(9, "chair", 0.9),  # touches the third by less than a tenth
    ]
    assert [(a.id, b.id) for a, b in near_namesakes(items)] == [(1, 2), (2, 3), (1, 3)]
    assert near_namesakes(items[3:]) == []


def test_lives_of_pairs_come_before_all_others_and_the_card_names_them():
    items = [thing(1, "armchair", 5.0), thing(2, "chair", 0.0), thing(3, "chair", 0.1), thing(4, "wall", 0, stuff=True)]
    text = lives_document(items, {3: [(7, "chair #3 appears: it is not chair #2, which is too far")]})
    assert text.startswith("**Two of one name in one place**")
    assert (
        text.splitlines()[2] == "- **chair #2 and #3**: frame 7: chair #3 appears: it is not chair #2, which is too far"
    )
    headings = [line for line in text.splitlines() if line.startswith("###")]
    assert headings == ["### chair #2", "### chair #3", "### armchair #1", "### wall #4"]
    assert pair_verdict(items)[0].startswith("**Perhaps mapped twice: chair #2 and #3**")
    assert pair_verdict(items[:2]) == []
    assert lives_document(items[:2], {}).startswith("Each detection")


def test_poses_are_compared_however_their_worlds_lie():
    poses = {frame: exp_se3(np.array([0, 0.02 * frame, 0, 0.1 * frame, 0.05 * frame**2, 0.0])) for frame in range(6)}
    elsewhere = exp_se3(np.array([0.3, -0.2, 0.5, 4.0, 5.0, 6.0]))
    given = {frame: elsewhere @ pose for frame, pose in poses.items()}
    located, apart = pose_verdict(poses, given, 8, 1)
    assert located == "Estimated: **6 of 8** frames located, 1 loop closed"
    assert "**0.0 cm** apart on average" in apart
    given[3] = given[3] @ exp_se3(np.array([0, 0, 0, 0.5, 0.0, 0.0]))
    assert "at most (frame 3)" in pose_verdict(poses, given, 6, 0)[1]
    assert len(pose_verdict(poses, {}, 6, 0)) == 1


EYE = Viewpoint(np.array([0.0, 0, -4]), np.zeros(3), np.array([0.0, -1, 0]))


def test_of_names_upon_each_other_the_first_stays():
    positions = np.array([[0.0, 0, 0], [0.02, 0, 0], [1.5, 0, 0], [0, 0.5, 0], [0, 0, -9]])
    assert clear_labels(positions, ["chair #1"] * 5, EYE, 600) == [0, 2, 3]  # the last lies behind the eye
    assert clear_labels(positions[::-1], ["chair #1"] * 5, EYE, 600) == [1, 2, 3]


def test_kept_names_do_not_overlap_on_the_screen():
    """By projecting corners of their rectangles with an ordinary pinhole camera."""
    rng = np.random.default_rng(5)
    positions, texts = rng.uniform(-2, 2, (80, 3)), [f"thing #{n}" for n in range(80)]
    eye = overview(positions, np.array([0, 0, 1.0]), np.array([0, 1.0, 0]))
    kept = clear_labels(positions, texts, eye, 500)
    assert 10 < len(kept) < 80
    forward = (eye.target - eye.position) / np.linalg.norm(eye.target - eye.position)
    right = np.cross(forward, eye.up) / np.linalg.norm(np.cross(forward, eye.up))
    relative = positions[kept] - eye.position
    focal_px = 250 / np.tan(np.radians(22.5))
    x, y = (focal_px * relative @ axis / (relative @ forward) for axis in (right, np.cross(forward, right)))
    for n in range(len(kept)):
        for m in range(n):
            assert abs(x[n] - x[m]) > 7 * len("thing #1") or abs(y[n] - y[m]) > 20
