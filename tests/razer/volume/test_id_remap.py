"""The table of ids: what became of each, and numbers for those that occur."""

from __future__ import annotations

import numpy as np
import torch

from razer.volume.id_remap import InstanceIdMap, numbered
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE


def test_ids_are_resolved_as_by_a_dictionary() -> None:
    rng = np.random.default_rng(0)
    table, now = InstanceIdMap(torch.device("cpu")), {0: 0}
    for step in range(200):
        table.admit(table.newest_id + 1)
        now[table.newest_id] = table.newest_id
        if step % 3 == 0:
            alive = sorted(set(now.values()) - {0})
            gone, survivor = int(rng.choice(alive)), int(rng.choice([0, *alive]))
            table.replace(gone, survivor)
            now = {i: survivor if of == gone else of for i, of in now.items()}
        assert table.resolve(torch.arange(table.newest_id + 1)).tolist() == list(now.values())
    table.admit(7)
    assert table.newest_id == 200


def test_new_ids_seldom_copy_the_table() -> None:
    table, places = InstanceIdMap(torch.device("cpu")), set[int]()
    for track_id in range(1, 4000):
        table.admit(track_id)
        places.add(table._of.data_ptr())
    assert len(places) < 20


def test_occurring_ids_are_numbered_in_order() -> None:
    known, number = numbered(torch.tensor([[9, 0], [4, 9]]), 20)
    assert known.tolist() == [0, 4, 9]
    assert number.tolist() == [[2, 0], [1, 2]]
    assert numbered(torch.zeros(0, dtype=torch.int32), 3)[0].tolist() == []


def test_counting_labels_takes_memory_for_those_that_occur() -> None:
    """Bins of all groups and of all ids ever given would be 80 GB."""
    voxels = VoxelMap(COARSE)
    voxels.admit(1_000_000)
    labels = torch.tensor([0, 999_999, 3], dtype=torch.int32, device=voxels.torch_device)
    group, cell = np.array([9_999, 0, 9_999, 9_999], np.int32), np.array([1, 0, 1, 2], np.int32)
    assert voxels.count_labels(labels, group, cell) == {(9_999, 999_999): 2, (9_999, 3): 1}
