"""Copies of a run folder: brought into a world of its own, with other poses, without an instance."""

from __future__ import annotations

import json
import shutil

import numpy as np
from scipy.spatial.transform import Rotation

from razer.storage.ply import read_mesh_ply, write_mesh_ply


def motion():
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("zyx", [70, 20, -35], degrees=True).as_matrix()
    matrix[:3, 3] = [3.0, -1.5, 0.75]
    return matrix


MOTION = motion()  # moved from own


def moved_copy(run, folder):
    shutil.copytree(run, folder)
    mesh = read_mesh_ply(run / "mesh.ply")
    mesh.vertices[:] = mesh.vertices.astype(float) @ MOTION[:3, :3].T + MOTION[:3, 3]
    write_mesh_ply(folder / "mesh.ply", mesh)
    content = json.loads((run / "instances.json").read_text())
    for item in content["instances"]:
        item["center"] = (MOTION[:3, :3] @ item["center"] + MOTION[:3, 3]).tolist()
        item["rotation"] = (MOTION[:3, :3] @ item["rotation"]).tolist()
    content["up"] = (MOTION[:3, :3] @ content["up"]).tolist()
    (folder / "instances.json").write_text(json.dumps(content))
    rows = np.loadtxt(run / "trajectory.txt")
    positions = rows[:, 1:4] @ MOTION[:3, :3].T + MOTION[:3, 3]
    turns = Rotation.from_matrix(MOTION[:3, :3]) * Rotation.from_quat(rows[:, 4:])
    write_trajectory(folder, rows[:, 0], positions, turns)
    return folder


def write_trajectory(folder, stamps, positions, turns):
    np.savetxt(folder / "trajectory.txt", np.column_stack([stamps, positions, turns.as_quat()]), fmt="%.12f")


def copy_with(run, folder, change):
    """A copy with changed (stamps, positions, rotations)."""
    shutil.copytree(run, folder)
    rows = np.loadtxt(run / "trajectory.txt")
    write_trajectory(folder, *change(rows[:, 0], rows[:, 1:4], Rotation.from_quat(rows[:, 4:])))
    return folder


def without(run, folder, number):
    """A copy that has not found one instance."""
    shutil.copytree(run, folder)
    mesh = read_mesh_ply(run / "mesh.ply")
    mesh.instances[mesh.instances == number] = 0
    write_mesh_ply(folder / "mesh.ply", mesh)
    content = json.loads((run / "instances.json").read_text())
    content["instances"] = [item for item in content["instances"] if item["id"] != number]
    (folder / "instances.json").write_text(json.dumps(content))
    return folder
