"""map.npz: the voxel volume, compressed, bit for bit."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.errors import BadInput
from razer.volume.voxel_map import VoxelMap

FORMAT = 1
ATTRIBUTES = ("tsdf", "weight", "color", "label", "ids", "counts")


def save_voxels(path: Path, voxels: VoxelMap) -> None:
    """The volume with all fusions carried through: sorted block keys, and the voxels that hold anything.

    Open3D's own file is uncompressed and keeps empty voxels, three times the size.
    """
    voxels.settle()
    keys, rows = voxels.active_rows()
    address = _all_addresses(rows)
    used = (voxels.attribute("weight")[address, 0] > 0) | (voxels.attribute("counts")[address] > 0).any(dim=1)
    arrays = {name: voxels.attribute(name)[address[used]].cpu().numpy() for name in ATTRIBUTES}
    arrays["keys"], arrays["used"] = keys, np.packbits(used.cpu().numpy())
    arrays["format"], arrays["newest_id"] = np.array(FORMAT), np.array(voxels.newest_id)
    arrays["settings"] = np.array(voxels.settings.model_dump_json())
    _write_npz(path, arrays)


def _write_npz(path: Path, arrays: Mapping[str, NDArray]) -> None:
    # zlib's fastest level: the higher ones take five times as long to save a tenth.
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def _all_addresses(rows: torch.Tensor) -> torch.Tensor:
    return (rows[:, None] * BLOCK_VOXELS + torch.arange(BLOCK_VOXELS, device=rows.device)).flatten()


def load_voxels(path: Path, device: str = "CPU:0") -> VoxelMap:
    """The volume as it was saved, bit for bit; raises BadInput if the file is not one."""
    try:
        return _restored(path, device)
    except BadInput:
        raise
    except (OSError, EOFError, KeyError, ValueError, IndexError, TypeError, AttributeError) as error:
        raise BadInput(f"{path} is no saved map, or is damaged: {error}") from error
    except (zipfile.BadZipFile, zlib.error, RuntimeError) as error:
        raise BadInput(f"{path} is damaged: {error}") from error


def _restored(path: Path, device: str) -> VoxelMap:
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if int(arrays["format"]) != FORMAT:
        raise BadInput(f"{path} has format {arrays['format']}, this version reads {FORMAT}")
    voxels = VoxelMap(VoxelSettings.model_validate_json(str(arrays["settings"])), device)
    voxels.allocate(arrays["keys"])
    address = _all_addresses(voxels.rows_of(arrays["keys"]))
    used = np.unpackbits(arrays["used"], count=len(address)).astype(bool)
    chosen = address[torch.from_numpy(used).to(address.device)]
    for name in ATTRIBUTES:
        voxels.attribute(name)[chosen] = torch.from_numpy(arrays[name]).to(address.device)
    voxels.admit(int(arrays["newest_id"]))
    return voxels
