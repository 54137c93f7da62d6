"""One frame through the method, on real input and at its edges."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools import open_sequence
from razer.config import MapperConfig
from razer.errors import UnusableFrame
from razer.mapper import Mapper
from razer.models import make_embedder, make_segmenter

LARGE_CELLS = 20  # smaller pieces of the geometric segmenter come and go from frame to frame


def make_mapper():
    return Mapper(MapperConfig(), make_segmenter("geometric", {}), make_embedder("appearance", {}))


@pytest.fixture(scope="module")
def kitchen(real_data):
    sequence = open_sequence(real_data / "redkitchen")
    mapper = make_mapper()
    steps = [mapper.step(sequence[i]) for i in range(0, 200, 5)]
    mapper.finish()
    return mapper, steps


def test_a_kitchen_has_its_table_floor_and_cabinets_as_large_instances(kitchen):
    mapper, _ = kitchen
    objects = mapper.snapshot().objects
    # The table top: flat, about a metre wide, and one piece.
    areas = sorted((np.prod(sorted(o.box.extent)[1:]) for o in objects), reverse=True)
    assert areas[0] > 2.0
    assert sum(area > 0.5 for area in areas) >= 4
    assert sum(track.n_voxels >= LARGE_CELLS for track in mapper.tracks) < 70


def test_every_detection_is_accounted_for(kitchen):
    mapper, steps = kitchen
    for step in steps:
        assert [d.detection for d in step.decisions] == list(range(len(step.detections)))
        matched = [d.track_id for d in step.decisions if d.outcome == "matched"]
        assert len(matched) == len(set(matched))
        assert set(np.unique(step.id_image)) - {0} <= {d.track_id for d in step.decisions}
    ids = [i for step in steps for i in step.born]
    assert ids == list(range(1, len(ids) + 1))
    gone = [g for step in steps for g, _ in step.fused] + [p for step in steps for p in step.pruned]
    assert len(gone) == len(set(gone))
    assert not {t.id for t in mapper.tracks} & set(gone)


def test_neighbouring_frames_are_mostly_matched_not_born(kitchen):
    _, steps = kitchen
    decisions = [(d, step.detections[d.detection]) for step in steps[5:] for d in step.decisions]
    outcomes = [decision.outcome for decision, detection in decisions if detection.n_cells >= LARGE_CELLS]
    assert len(outcomes) > 600
    assert outcomes.count("born") < 0.2 * len(outcomes)


def test_a_frame_that_cannot_be_used_changes_nothing(real_data):
    sequence = open_sequence(real_data / "redkitchen")
    mapper = make_mapper()
    frame = sequence[0]
    mapper.step(frame)
    before = (mapper.voxels.n_blocks, len(mapper.tracks), mapper.voxels.attribute("weight").sum().item())
    far = frame.at(frame.pose)
    for broken in (
        type(far)(1, 0.1, far.rgb, np.full_like(far.depth, 40.0), far.intrinsics, far.pose),
        type(far)(1, 0.1, far.rgb, far.depth, far.intrinsics, None),
    ):
        with pytest.raises(UnusableFrame):
            mapper.step(broken)
    after = (mapper.voxels.n_blocks, len(mapper.tracks), mapper.voxels.attribute("weight").sum().item())
    assert after == before
