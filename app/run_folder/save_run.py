"""Fills a run folder with what a run found."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from app.frames.cameras.color_registration import ColorRegistration, json_text
from app.frames.frame_accounting import FrameAccounting
from app.render.glb import write_map_glb
from app.run_folder import run_folder as names
from app.run_folder.run_folder import RunFolder
from app.settings.run_config import RunConfig
from data_tools.recordings.trajectories import tum_text
from razer.frame import Intrinsics
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.storage.embeddings_npz import write_embeddings_npz
from razer.storage.instances_json import write_instances_json
from razer.storage.parts_npz import write_parts_npz
from razer.storage.ply import write_mesh_ply
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from razer.storage.volume_npz import save_voxels
from slam.report import GraphReport

POSE_COVARIANCES_FORMAT = 1


def save_run(
    folder: RunFolder, config: RunConfig, name: str, mapper: Mapper, panoptic: PanopticMap, accounting: FrameAccounting
) -> None:
    """Write every file of a run but the timeline and the timings."""
    save_config(folder, config, name)
    save_poses(folder, accounting)
    save_given_poses(folder, config, accounting)
    folder.write(names.MESH_PLY, lambda path: write_mesh_ply(path, panoptic.mesh))
    stamps = dict(zip(accounting.indices, accounting.stamps, strict=True))
    folder.write(names.MESH_GLB, lambda path: write_map_glb(path, panoptic))
    parts, up = panoptic.parts, panoptic.up
    folder.write(names.INSTANCES, lambda path: write_instances_json(path, panoptic.objects, up, stamps, parts))
    folder.write(names.EMBEDDINGS, lambda path: write_embeddings_npz(path, [*panoptic.objects, *parts]))
    if (vertex_parts := panoptic.vertex_parts) is not None:
        folder.write(names.PARTS, lambda path: write_parts_npz(path, vertex_parts))
    folder.write(names.VOXELS, lambda path: save_voxels(path, mapper.voxels))


def save_poses(folder: RunFolder, accounting: FrameAccounting) -> None:
    """Write trajectory.txt, and pose_covariances.npz where poses were estimated to the end."""
    folder.write(names.TRAJECTORY, lambda path: _write_text(path, tum_text(accounting.stamps, accounting.poses)))
    if (graph := accounting.graph) is not None:
        folder.write(names.POSE_COVARIANCES, lambda path: write_pose_covariances(path, graph))


def save_given_poses(folder: RunFolder, config: RunConfig, accounting: FrameAccounting) -> None:
    """Write given_trajectory.txt, the poses that those of trajectory.txt were corrected from, where they were."""
    if config.input.poses != "refine":
        return
    both = [(stamp, accounting.given[i]) for i, stamp in zip(accounting.indices, accounting.stamps, strict=True)]
    text = tum_text([stamp for stamp, _ in both], [pose for _, pose in both])
    folder.write(names.GIVEN_TRAJECTORY, lambda path: _write_text(path, text))


def save_config(folder: RunFolder, config: RunConfig, name: str) -> None:
    """Write config.toml, the settings of a run over the recording `name`."""
    header = f"Settings of a run over {name}; `razer run --config` reads this file."
    folder.write(names.CONFIG, lambda path: _write_text(path, toml_text(list_settings(config), header)))


def save_registration(folder: RunFolder, registration: ColorRegistration) -> None:
    """Write rgbd_calibration.json."""
    folder.write(names.RGBD_CALIBRATION, lambda path: _write_text(path, json_text(registration)))


def save_camera(folder: RunFolder, camera: Intrinsics) -> None:
    """Write camera.json, in the form that `--intrinsics FILE.json` reads."""
    folder.write(names.CAMERA, lambda path: _write_text(path, json.dumps(asdict(camera)) + "\n"))


def save_timings(folder: RunFolder, timings: dict[str, Any]) -> None:
    """Write timings.json."""
    folder.write(names.TIMINGS, lambda path: _write_text(path, json.dumps(timings, indent=1) + "\n"))


def write_pose_covariances(path: Path, graph: GraphReport) -> None:
    """Format 1: of each keyframe whose marginal covariance is known, `frames` (K,) its index, `stamps` (K,) seconds,
    `world_from_camera` (K, 4, 4), and `covariances` (K, 6, 6) of xi = (rotation x y z, radians; shift x y z, metres)
    along the camera's own axes, where the true pose is world_from_camera exp(xi). Of each stretch of frames in which a
    direction was open, `open_frames` (S, 2) are the first and the last, `open_axes` (S, 3) the axis in the camera."""
    rows = [row for row, frame in enumerate(graph.frames.tolist()) if frame in graph.covariances]
    np.savez_compressed(
        path,
        format=POSE_COVARIANCES_FORMAT,
        frames=graph.frames[rows],
        stamps=graph.stamps[rows],
        world_from_camera=graph.world_from_camera[rows],
        covariances=np.array([graph.covariances[int(graph.frames[row])] for row in rows]).reshape(-1, 6, 6),
        open_frames=np.array([(stretch.first, stretch.last) for stretch in graph.open], np.int64).reshape(-1, 2),
        open_axes=np.array([stretch.axis for stretch in graph.open]).reshape(-1, 3),
    )


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
