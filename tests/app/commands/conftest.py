"""A small mapped room that the tests of several verbs look at."""

from __future__ import annotations

import shutil

import pytest

from tests.support.cli import ROOM_FRAMES, ROOM_SIZE, map_oracle_room


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """(run, recording) of a small room with perfect masks, which nobody writes to."""
    return map_oracle_room(tmp_path_factory.mktemp("room"), ROOM_FRAMES, ROOM_SIZE)


@pytest.fixture
def run(made, tmp_path):
    """A copy of the run, to be written to."""
    return shutil.copytree(made[0], tmp_path / "run")
