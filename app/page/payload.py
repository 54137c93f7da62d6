"""What the page shows of a run, as one packet: mesh, instances, relations, pictures, camera path."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from app.page.camera_path import camera_path
from app.page.crop_pictures import crop_pictures
from app.page.display_geometry import MAX_TRIANGLES, display_geometry
from app.page.instance_records import instance_records, kinds_of, relation_records
from app.page.mesh_codec import EncodedMesh, encode_mesh
from app.page.other_poses import OtherPoses, chosen_run, other_poses
from app.page.packet import SMALLEST, pack
from app.query.queryable_map import open_map
from app.run_folder.run_folder import CAMERA
from app.settings.run_config import RunConfig
from razer.files import MALFORMED, read_json
from razer.geometry import transform_points
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.saved_map import load_map

FORMAT = 1
_QUICK = 4  # of zlib's levels: a sixth larger, in a fifth of the time


def page_payload(run: Path, epoch: int = 0, opened: tuple[PanopticMap, RunConfig] | None = None) -> bytes:
    """The packet (`app.page.packet`) of a finished run, or of the pair that `razer run --poses both` leaves; `opened`:
    its map with the settings, where it is open already and the packet is made for one look at it: quickly, if larger.

    Raises BadInput naming what is missing or damaged.
    """
    run = chosen_run(run)
    panoptic, config = opened or open_map(run)
    encoded = _encoded(panoptic.mesh)
    pictures = crop_pictures(run, config, panoptic)
    header = map_header(panoptic, run.absolute().name) | {
        "epoch": epoch,
        "mesh": encoded.header,
        "notes": _notes(panoptic, encoded.header["triangles"]),
        "camera_path": camera_path(run),
        "camera": _camera(run),
        "crops": {str(i): [len(file) for file in files] for i, files in pictures.items()},
    }
    for record in header["instances"]:
        record["crops"] = len(pictures.get(record["id"], ()))
    sections = dict(encoded.sections)
    sections["crops"] = b"".join(file for files in pictures.values() for file in files)
    if (other := other_poses(run)) is not None:
        header["other"], of_other = _other(other)
        sections |= of_other
    return pack(header, sections, SMALLEST if opened is None else _QUICK)


def growing_payload(panoptic: PanopticMap, title: str, epoch: int = 0) -> bytes:
    """The packet of a map that grows: all but its mesh, which comes block by block, and its relations, which take
    long."""
    header = map_header(panoptic, title, with_relations=False) | {"epoch": epoch, "growing": True}
    for record in header["instances"]:
        record["crops"] = 0  # pictures are cut when the run is done
    return pack(header, {})


def map_header(panoptic: PanopticMap, title: str, *, with_relations: bool = True) -> dict[str, Any]:
    """The part of the header that needs the map alone, finished or growing."""
    instances = instance_records(panoptic)
    names = sorted({record["name"] for record in instances})
    return {
        "format": FORMAT,
        "epoch": 0,
        "title": title,
        "up": panoptic.up_or_z.tolist(),
        "instances": instances,
        "relations": relation_records(panoptic) if with_relations else [],
        "kinds": kinds_of(names),
        "notes": [],
        "camera_path": None,
        "camera": None,
        "crops": {},
        "mesh": None,
        "other": None,
    }


def _encoded(mesh: LabelledMesh, max_triangles: int = MAX_TRIANGLES, prefix: str = "") -> EncodedMesh:
    geometry = display_geometry(mesh, max_triangles)
    return encode_mesh(geometry.mesh(mesh), geometry.occlusion, prefix, geometry.order)


def _notes(panoptic: PanopticMap, n_shown: int) -> list[str]:
    n_all = len(panoptic.mesh.triangles)
    return [] if n_all <= MAX_TRIANGLES else [f"Shown with {n_shown:,} of {n_all:,} triangles."]


def _camera(run: Path) -> dict[str, float] | None:
    try:
        camera = read_json(run / CAMERA)
        return {key: float(camera[key]) for key in ("width", "height", "fx", "fy")}
    except MALFORMED:
        return None


def _other(other: OtherPoses) -> tuple[dict[str, Any], dict[str, bytes]]:
    """The map of the other poses in the frame of the first."""
    mesh = load_map(other.folder).mesh
    moved = transform_points(other.a_from_b, mesh.vertices.astype("f8")).astype("f4")
    encoded = _encoded(replace(mesh, vertices=moved), MAX_TRIANGLES // 2, "other_")
    return {"mesh": encoded.header, "camera_path": camera_path(other.folder, other.a_from_b)}, encoded.sections
