"""Fixtures that all tests may use."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

# What models the developer has must not change what "auto" means in a test; read when huggingface_hub is imported.
os.environ["HF_HOME"] = str(Path(tempfile.gettempdir()) / "razer-tests-have-no-models")
os.environ.pop("HF_HUB_CACHE", None)
# Tests import it before the project does, which would see to that.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder with the real recordings, $RAZER_TEST_DATA/data."""
    root = os.environ.get("RAZER_TEST_DATA")
    if not root:
        pytest.skip("RAZER_TEST_DATA is not set: no real recordings to test on")
    return Path(root) / "data"


@pytest.fixture(scope="session")
def cuda() -> str:
    """The CUDA device, as Open3D names it."""
    import open3d.core as o3c
    import torch

    if not (o3c.cuda.is_available() and torch.cuda.is_available()):
        pytest.skip("needs a CUDA device, and builds of Open3D and torch that use it")
    return "CUDA:0"


@pytest.fixture(autouse=True)
def waits_are_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """How long a verb takes here says nothing about it: lines that come after a second are for their own tests."""
    from app.console import waiting

    monkeypatch.setattr(waiting, "FIRST_S", 3600.0)


@pytest.fixture(scope="session", autouse=True)
def maps_on_the_device_asked_for() -> None:
    """With $RAZER_TEST_DEVICE, such as CUDA:0, maps live there wherever a test does not say where."""
    if not (device := os.environ.get("RAZER_TEST_DEVICE")):
        return
    from razer.mapper import Mapper
    from razer.storage import volume_npz
    from razer.volume.voxel_map import VoxelMap

    VoxelMap.__init__.__defaults__ = (device, None)
    Mapper.__init__.__kwdefaults__["device"] = device
    volume_npz.load_voxels.__defaults__ = (device,)
