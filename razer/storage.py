"""What the method saves and loads: mesh, instances, embeddings and the volume itself. Each format is versioned."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from razer.arrays import Float64Array, Int32Array
from razer.boxes.oriented_box import OrientedBox
from razer.config import VoxelSettings
from razer.detection.best_views import BestView
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.errors import BadInput
from razer.panoptic_map import MapObject, PanopticMap
from razer.volume.mesh_extraction import LabelledMesh
from razer.volume.voxel_map import VoxelMap

FORMAT = 1
ATTRIBUTES = ("tsdf", "weight", "color", "label", "ids", "counts")
VERTEX = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("red", "u1"),
        ("green", "u1"),
        ("blue", "u1"),
        ("instance", "<i4"),
    ]
)
FACE = np.dtype([("n", "u1"), ("a", "<i4"), ("b", "<i4"), ("c", "<i4")])
PLY_TYPES = {"<f4": "float", "|u1": "uchar", "<i4": "int"}


def write_mesh_ply(path: Path, mesh: LabelledMesh) -> None:
    """Binary PLY with the instance of each vertex as an integer property."""
    vertices = vertex_rows(mesh, VERTEX)
    vertices["instance"] = mesh.instances
    write_ply(path, vertices, mesh.triangles)


def write_ply(path: Path, vertices: NDArray, triangles: Int32Array) -> None:
    """Binary PLY of vertices (V,) with named fields of the types in PLY_TYPES, and triangles (T, 3)."""
    faces = np.empty(len(triangles), FACE)
    faces["n"] = 3
    faces["a"], faces["b"], faces["c"] = triangles.T
    fields = vertices.dtype
    properties = [f"property {PLY_TYPES[fields[name].str]} {name}" for name in fields.names or ()]
    header = [
        "ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *properties,
        f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", "",
    ]  # fmt: skip
    path.write_bytes("\n".join(header).encode() + vertices.tobytes() + faces.tobytes())


def vertex_rows(mesh: LabelledMesh, fields: np.dtype) -> NDArray:
    """Rows (V,) with the given fields, of which place and colour are filled."""
    vertices = np.zeros(len(mesh.vertices), fields)
    for i, name in enumerate("xyz"):
        vertices[name] = mesh.vertices[:, i]
    for i, name in enumerate(("red", "green", "blue")):
        vertices[name] = mesh.colors[:, i]
    return vertices


def read_mesh_ply(path: Path) -> LabelledMesh:
    """Read a mesh that `write_mesh_ply` wrote; raises BadInput if it is another kind of file."""
    if not path.is_file():
        raise BadInput(f"{path} does not exist: give the mesh.ply of a run")
    data = path.read_bytes()
    start = data.find(b"end_header\n") + len(b"end_header\n")
    header = data[:start].decode("ascii", "replace")
    counts = [int(n) for n in re.findall(r"^element (?:vertex|face) (\d+)$", header, re.MULTILINE)]
    names = re.findall(r"^property (?!list)\w+ (\w+)$", header, re.MULTILINE)
    if len(counts) != 2 or tuple(names) != VERTEX.names:
        raise BadInput(f"{path} is no mesh of a run: expected vertices with {', '.join(VERTEX.names or ())}")
    if len(data) - start != counts[0] * VERTEX.itemsize + counts[1] * FACE.itemsize:
        raise BadInput(f"{path} is cut short: run again to write it anew")
    vertices = np.frombuffer(data, VERTEX, counts[0], start)
    faces = np.frombuffer(data, FACE, counts[1], start + vertices.nbytes)
    return LabelledMesh(
        np.stack([vertices[n] for n in "xyz"], axis=1),
        np.stack([vertices[n] for n in ("red", "green", "blue")], axis=1),
        vertices["instance"].astype(np.int32),
        np.stack([faces[n] for n in "abc"], axis=1),
    )


def write_instances_json(
    path: Path,
    panoptic: PanopticMap,
    up: Float64Array | None = None,
    stamps: Mapping[int, float] | None = None,
) -> None:
    """All instances with their boxes; `up` (3,) is the world's upward direction where it is known, and `stamps` the
    seconds of frames by their index."""
    content = {
        "format": FORMAT,
        "frame": "world, metres, right-handed",
        "up": None if up is None else _rounded(up),
        "instances": [_instance(o, stamps or {}) for o in panoptic.objects],
    }
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _instance(found: MapObject, stamps: Mapping[int, float]) -> dict[str, object]:
    return {
        "id": found.id,
        "class": found.class_name,
        "score": round(found.score, 4),
        **box_entry(found.box),
        "n_voxels": found.n_voxels,
        "n_vertices": found.n_vertices,
        "observations": found.observations,
        "first_frame": found.first_frame,
        "last_frame": found.last_frame,
        "best_views": [_view(view, stamps.get(view.frame, view.stamp)) for view in found.views],
    }


def _view(view: BestView, stamp: float | None) -> dict[str, object]:
    region = view.region
    return {
        "frame": view.frame,
        "stamp": stamp,
        "box": list(region.box),
        "pixels": region.pixels,
        "whole": region.whole,
    }


def box_entry(box: OrientedBox) -> dict[str, object]:
    """A box in a JSON file: center and extent in metres, rotation world from box."""
    rotation = [_rounded(row, 8) for row in box.rotation]
    return {"center": _rounded(box.center), "extent": _rounded(box.extent), "rotation": rotation}


def _rounded(values: NDArray, digits: int = 5) -> list[float]:
    return [round(float(v), digits) for v in values]


def write_embeddings_npz(path: Path, panoptic: PanopticMap) -> None:
    """The embedding banks: ids (R,), embeddings (R, D), weights (R,), a row for each hypothesis."""
    objects = [o for o in panoptic.objects if len(o.embeddings)]
    width = objects[0].embeddings.shape[1] if objects else 0
    np.savez_compressed(
        path,
        format=FORMAT,
        ids=np.concatenate([np.full(len(o.weights), o.id, np.int32) for o in objects] or [np.zeros(0, np.int32)]),
        embeddings=np.concatenate([o.embeddings for o in objects] or [np.zeros((0, width), np.float32)]),
        weights=np.concatenate([o.weights for o in objects] or [np.zeros(0)]),
    )


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
