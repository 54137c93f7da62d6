"""A recording that takes a while to map."""

from __future__ import annotations

import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory):
    """A walk through a room with its masks, which nobody writes to."""
    room = SyntheticRoom(0, 120, 320, 240)
    folder = tmp_path_factory.mktemp("live") / "recording"
    write_recording(room, folder, truth=room.truth(0.05), lossless=True)
    return folder
