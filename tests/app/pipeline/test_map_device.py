"""Which device the map lives on, by the setting and by what Open3D and torch find."""

from __future__ import annotations

import open3d as o3d
import pytest
import torch

from app.pipeline.prepare_run import make_mapper
from app.settings.run_config import RunConfig
from razer.errors import BadInput


def asked_for(device: str) -> RunConfig:
    return RunConfig.model_validate(
        {"run": {"device": device}, "segmenter": {"name": "geometric"}, "embedder": {"name": "appearance"}}
    )


@pytest.mark.parametrize(
    ("open3d_has", "torch_has", "said"),
    [
        (False, True, "Open3D finds no CUDA"),
        (True, False, "torch finds no CUDA"),
        (False, False, "Open3D and torch find no CUDA"),
    ],
)
def test_cuda_is_taken_where_both_libraries_have_it(
    open3d_has: bool, torch_has: bool, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The map's tensors are shared between both; a torch without CUDA is what the README's installation leads to."""
    monkeypatch.setattr(o3d.core.cuda, "is_available", lambda: open3d_has)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: torch_has)
    assert str(make_mapper(asked_for("auto")).voxels.device) == "CPU:0"
    with pytest.raises(BadInput, match=said):
        make_mapper(asked_for("cuda"))


@pytest.mark.gpu
def test_auto_takes_cuda(cuda: str) -> None:
    assert str(make_mapper(asked_for("auto")).voxels.device) == cuda
    assert str(make_mapper(asked_for("cpu")).voxels.device) == "CPU:0"
