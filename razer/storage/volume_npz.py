"""map.npz: the voxel volume, compressed, bit for bit."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import Uint8Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.errors import BadInput, UnusableFrame
from razer.files import MALFORMED, parse_json, read_npz
from razer.volume.blocks.block_pages import BLOCKS_AT_ONCE, addresses_in
from razer.volume.voxel_map import VoxelMap

FORMAT = 1
ATTRIBUTES = ("tsdf", "weight", "color", "label", "ids", "counts")
# What volumes were made with that were saved before there were these settings.
FORMER_SETTINGS = {"surface_share": 2.0, "vertex_labels": "votes", "seam_rings": 3}


def save_voxels(path: Path, voxels: VoxelMap) -> None:
    """The volume with all fusions carried through: sorted block keys, and the voxels that hold anything.

    Open3D's own file is uncompressed and keeps empty voxels, three times the size.
    """
    voxels.settle()
    keys, rows = voxels.pages.all()
    parts = rows.split(BLOCKS_AT_ONCE)
    masks = (voxels.pages.mask(part, _is_used, "weight", "counts") for part in parts)
    used = [np.packbits(mask.cpu().numpy()) for mask in masks]
    n_used = sum(int(np.bitwise_count(bits).sum()) for bits in used)
    small = {
        "keys": keys,
        "used": np.concatenate([np.zeros(0, np.uint8), *used]),
        "format": np.array(FORMAT),
        "newest_id": np.array(voxels.newest_id),
        "settings": np.array(voxels.settings.model_dump_json()),
    }
    # zlib's fastest level: the higher ones take five times as long to save a tenth.
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name in ATTRIBUTES:
            addresses = (addresses_in(part, _unpacked(bits, part)) for part, bits in zip(parts, used, strict=True))
            pieces = (voxels.pages.read(part, name)[0].cpu().numpy() for part in addresses)
            _write_pieces(archive, name, n_used, pieces)
        for name, array in small.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def _is_used(weight: Tensor, counts: Tensor) -> Tensor:
    return (weight[..., 0] > 0) | (counts > 0).any(dim=2)


def _unpacked(bits: Uint8Array, rows: Tensor) -> Tensor:
    """The mask (B, 4096) of blocks of given rows (B,)."""
    mask = np.unpackbits(bits).astype(np.bool_).reshape(len(rows), BLOCK_VOXELS)
    return torch.from_numpy(mask).to(rows.device)


def _write_pieces(archive: zipfile.ZipFile, name: str, n: int, pieces: Iterable[NDArray]) -> None:
    """An array of n rows that never is in memory as a whole."""
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        for number, piece in enumerate(pieces):
            if number == 0:
                header = {"descr": piece.dtype.str, "fortran_order": False, "shape": (n, *piece.shape[1:])}
                np.lib.format.write_array_header_1_0(member, header)
            member.write(piece.tobytes())


def load_voxels(path: Path, device: str = "CPU:0") -> VoxelMap:
    """The volume as it was saved, bit for bit; raises BadInput if the file is not one."""
    try:
        return _restored(path, device)
    except UnusableFrame as error:  # what the volume says of blocks
        raise BadInput(f"{path} is damaged: {error}") from error
    except BadInput:
        raise
    except MALFORMED as error:
        raise BadInput(f"{path} is no saved map, or is damaged: {error}") from error
    except RuntimeError as error:  # what torch says of arrays that it cannot use
        raise BadInput(f"{path} is damaged: {error}") from error


def _restored(path: Path, device: str) -> VoxelMap:
    arrays = read_npz(path, ["format", "settings", "keys", "used", "newest_id", *ATTRIBUTES])
    if int(arrays["format"]) != FORMAT:
        raise BadInput(f"{path} has format {arrays['format']}, this version reads {FORMAT}")
    voxels = VoxelMap(_settings_of(str(arrays["settings"]), path), device)
    voxels.allocate(arrays["keys"])
    rows = voxels.rows_of(arrays["keys"])
    used = np.unpackbits(arrays["used"], count=len(rows) * BLOCK_VOXELS).astype(bool).reshape(-1, BLOCK_VOXELS)
    addresses = addresses_in(rows, torch.from_numpy(used).to(rows.device))
    if {len(arrays[name]) for name in ATTRIBUTES} != {len(addresses)}:
        raise ValueError("its arrays are not of one length")
    voxels.pages.write(addresses, **{name: torch.from_numpy(arrays[name]).to(rows.device) for name in ATTRIBUTES})
    voxels.admit(int(arrays["newest_id"]))
    return voxels


def _settings_of(saved: str, path: Path) -> VoxelSettings:
    """The settings that a volume was made with, by those that were saved as JSON."""
    settings = FORMER_SETTINGS | parse_json(saved, f"{path}, member settings")
    settings["surface_weight"] = max(1.0, settings["surface_weight"])  # it was less where all that was seen is surface
    return VoxelSettings.model_validate(settings)
