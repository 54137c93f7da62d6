"""Fixtures that all tests may use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder with the real recordings, $RAZER_TEST_DATA/data."""
    root = os.environ.get("RAZER_TEST_DATA")
    if not root:
        pytest.skip("RAZER_TEST_DATA is not set: no real recordings to test on")
    return Path(root) / "data"
