"""How many observations surface asks for, by hand: a share of those of the block, within one and enough."""

from __future__ import annotations

import pytest
import torch

from razer.config import VoxelSettings
from razer.volume.surface_evidence import is_observed_enough


@pytest.mark.parametrize(
    ("share", "enough", "of_block", "asked"),
    [
        (0.05, 3.0, 1, 1),
        (0.05, 3.0, 20, 1),
        (0.05, 3.0, 21, 2),
        (0.05, 3.0, 40, 2),
        (0.05, 3.0, 41, 3),
        (0.05, 3.0, 9000, 3),
        (0.05, 1.0, 9000, 1),
        (0.0, 3.0, 9000, 1),
        (1.0, 3.0, 2, 2),
        (1.0, 3.0, 9000, 3),
        (2.0, 3.0, 2, 3),  # nothing of such a block is surface
        (2.0, 3.0, 9000, 3),
        (2.0, 5.0, 4, 5),
    ],
)
def test_surface_asks_for_so_many_observations(share: float, enough: float, of_block: int, asked: int) -> None:
    settings = VoxelSettings(surface_share=share, surface_weight=enough)
    weight = torch.arange(7.0).clamp(max=of_block)
    blocks = torch.stack([torch.cat([weight, torch.tensor([float(of_block)])]), torch.zeros(8)])
    expected = [[n >= asked for n in row] for row in blocks.tolist()]
    assert is_observed_enough(blocks, settings).tolist() == expected


def test_what_nobody_saw_is_no_surface() -> None:
    assert not is_observed_enough(torch.zeros((2, 8)), VoxelSettings(surface_share=0.0)).any()
