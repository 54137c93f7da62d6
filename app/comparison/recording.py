"""Rerun recording of a comparison: both maps, each part of which can be shown and hidden."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.comparison.compare_runs import Comparison
from app.render.mesh_decimation import decimated
from app.render.viewpoint import Viewpoint, overview
from app.run_folder.mapped_run import MappedRun
from app.timeline.recording.layout import scene_layout
from app.timeline.recording.rerun_log import RerunLog
from razer.map_object import MapObject

Color = tuple[int, int, int]
BLUE, ORANGE, GREEN, RED, VIOLET = (31, 111, 180), (230, 120, 30), (40, 160, 60), (214, 39, 40), (123, 63, 181)
GREY = (90, 90, 90)
MAX_VERTICES = 300_000
CLOSE_TIMEOUT_S = 20.0


def write_recording(path: Path, result: Comparison) -> None:
    """The surfaces of A (bluish) and B (orange), trajectories (the true one green), boxes, and lines that join the
    centres of pairs; missed boxes are red, extra ones violet."""
    log = RerunLog(path)
    matching = result.instances
    for side, run, color in (("a", result.a, BLUE), ("b", result.b, ORANGE)):
        _log_mesh(log, f"{side}/mesh", run, color)
        if run.trajectory is not None:
            log.line_style(f"{side}/trajectory", color)
            log.lines(f"{side}/trajectory", [run.trajectory.world_from_camera[:, :3, 3]])
    if result.truth_trajectory is not None:
        log.line_style("truth/trajectory", GREEN)
        log.lines("truth/trajectory", [result.truth_trajectory.world_from_camera[:, :3, 3]])
    _log_boxes(log, "a/matched", tuple(match.a for match in matching.matched), BLUE)
    _log_boxes(log, "b/matched", tuple(match.b for match in matching.matched), ORANGE)
    _log_boxes(log, "a/missed", matching.missed, RED)
    _log_boxes(log, "b/extra", matching.extra, VIOLET)
    log.line_style("pairs", GREY)
    log.lines("pairs", [np.stack([match.a.box.center, match.b.box.center]) for match in matching.matched])
    log.show(scene_layout(_viewpoint(result.a)))
    log.close(CLOSE_TIMEOUT_S)


def _viewpoint(run: MappedRun) -> Viewpoint:
    """Above a map, behind where the camera looked on average."""
    points, up, forward = run.panoptic.mesh.vertices.astype(np.float64), run.panoptic.up_or_z, np.array([1.0, 0.0, 0.0])
    if run.trajectory is not None:
        poses = run.trajectory.world_from_camera
        points, forward = np.concatenate([points, poses[:, :3, 3]]), poses[:, :3, 2].mean(axis=0)
    return overview(points, up=up, forward=forward)


def _log_mesh(log: RerunLog, entity: str, run: MappedRun, color: Color) -> None:
    mesh = decimated(run.panoptic.mesh, MAX_VERTICES)
    if len(mesh.vertices):
        mixed = (mesh.colors.astype(np.uint16) + np.array(color, np.uint16)) // 2
        log.mesh(entity, mesh, mixed.astype(np.uint8))


def _log_boxes(log: RerunLog, entity: str, objects: tuple[MapObject, ...], color: Color) -> None:
    if objects:
        labels = [f"#{o.id} {o.class_name or ''}".rstrip() for o in objects]
        log.boxes(entity, [o.box for o in objects], np.tile(np.array(color, np.uint8), (len(objects), 1)), labels)
