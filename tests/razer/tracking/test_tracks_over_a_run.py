"""What tracks do over a run, from the outside: frames with known instances go in, and who was found again comes out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pytest
import torch

import razer.volume.blocks.block_pages
from razer.config import MapperConfig
from razer.frame import Frame
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.tracking.step_result import StepResult
from tests.support.scenes import COARSE, axis_box, box_depth, frame_of, plane_depth, pose

WALL_M, SIZE_M = 2.2, 0.4
Places = Mapping[int, float]  # where along x the box of each instance stands


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread, and room for what these maps need."""
    torch.set_num_threads(1)
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


def boxes_before_wall(index: int, camera_x_m: float, boxes: Places) -> Frame:
    """A frame of boxes that stand before a wall which is nobody's."""
    at = pose((camera_x_m, -0.1, 0), (2, 0, 0))
    depth, ids = plane_depth(at, (0, 0, 1), WALL_M), np.zeros((120, 160), np.int32)
    for instance, x_m in boxes.items():
        its_depth = box_depth(at, axis_box((x_m, 0, 1.7), (SIZE_M, SIZE_M, SIZE_M)))
        ids = np.where(its_depth < depth, instance, ids)
        depth = np.minimum(depth, its_depth)
    frame = frame_of(depth, at, index=index)
    return Frame(index, frame.stamp, frame.rgb, frame.depth, frame.intrinsics, at, ids)


def mapped(frames: Iterable[Frame]) -> tuple[Mapper, list[dict[int, int]], list[StepResult]]:
    """The map, and for each frame the track that each instance was given."""
    mapper = Mapper(MapperConfig(voxels=COARSE), OracleSegmenter("none"), OracleEmbedder("none"))
    owners, steps = [], []
    for frame in frames:
        step = mapper.step(frame)
        shown = {}
        for instance in np.unique(frame.instance_ids[frame.instance_ids > 0]):
            tracks, counts = np.unique(step.id_image[frame.instance_ids == instance], return_counts=True)
            shown[int(instance)] = int(tracks[counts.argmax()])
        owners.append(shown)
        steps.append(step)
    mapper.finish()
    return mapper, owners, steps


def centres_x_m(mapper: Mapper) -> list[float]:
    return sorted(float(found.box.center[0]) for found in mapper.snapshot().objects)


PAIR = {1: -0.3, 2: 0.3}


def test_things_side_by_side_are_born_once_in_order_and_keep_their_tracks() -> None:
    mapper, owners, steps = mapped(boxes_before_wall(i, 0.03 * i - 0.15, PAIR) for i in range(10))
    assert owners == [{1: 2, 2: 1}] * 10  # the box on the right is nearer, and its mask is larger
    assert [decision.outcome for decision in steps[0].decisions] == ["born", "born"]
    assert {decision.outcome for step in steps[1:] for decision in step.decisions} == {"matched"}
    assert sorted(track.id for track in mapper.tracks) == [1, 2]
    assert centres_x_m(mapper) == pytest.approx([-0.3, 0.3], abs=COARSE.voxel_size_m)
    assert [found.observations for found in mapper.snapshot().objects] == [10, 10]


def test_the_order_in_which_masks_come_changes_nothing() -> None:
    one, _, _ = mapped(boxes_before_wall(i, 0.03 * i - 0.15, PAIR) for i in range(8))
    other, owners, _ = mapped(boxes_before_wall(i, 0.03 * i - 0.15, {1: 0.3, 2: -0.3}) for i in range(8))
    assert owners[-1] == {1: 1, 2: 2}  # as before: track 1 is the box on the right, which is instance 1 now
    assert centres_x_m(one) == pytest.approx(centres_x_m(other), abs=1e-6)
    sizes = [sorted(found.n_vertices for found in mapper.snapshot().objects) for mapper in (one, other)]
    assert sizes[0] == sizes[1]


def test_a_thing_that_was_out_of_view_for_long_is_found_again() -> None:
    far = {1: 0.0, 2: 4.0}
    path_m = [*np.linspace(-0.1, 0.1, 6), *np.linspace(3.9, 4.1, 15), *np.linspace(0.1, -0.1, 4)]
    mapper, owners, steps = mapped(boxes_before_wall(i, x_m, far) for i, x_m in enumerate(path_m))
    assert [shown.get(1) for shown in owners] == [1] * 6 + [None] * 15 + [1] * 4
    assert not [gone for step in steps for gone in step.pruned]
    assert centres_x_m(mapper) == pytest.approx([0.0, 4.0], abs=COARSE.voxel_size_m)


def test_what_one_frame_of_many_invents_is_no_instance() -> None:
    def shown(i: int) -> Frame:
        to_and_fro_m = 0.02 * abs((i + 8) % 16 - 8)
        frame = boxes_before_wall(i, to_and_fro_m - 0.1, {1: -0.3})
        if i == 4:
            frame.instance_ids[30:80, 100:150] = 7  # a patch of the bare wall
        return frame

    mapper, _, _ = mapped(shown(i) for i in range(40))  # of which 36 frames, 4.8 views, do not show it
    assert [found.id for found in mapper.snapshot().objects] == [1]
    assert set(np.unique(mapper.snapshot().mesh.instances)) == {0, 1}


def test_no_track_takes_part_after_it_is_gone() -> None:
    def shown(i: int) -> Frame:
        frame = boxes_before_wall(i, 0.02 * i - 0.3, PAIR)
        if i % 5 == 1:
            frame.instance_ids[10:60, 10 + 3 * i : 40 + 3 * i] = 10 + i
        return frame

    mapper, _, steps = mapped(shown(i) for i in range(20))
    gone: set[int] = set()
    born: list[int] = []
    for step in steps:
        assert not gone & {decision.track_id for decision in step.decisions}
        born += step.born
        gone |= {lost for lost, _ in step.fused} | set(step.pruned)
    assert born == list(range(1, len(born) + 1))
    assert gone < set(born)
    assert {track.id for track in mapper.tracks} <= set(born) - gone
