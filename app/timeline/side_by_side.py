"""Two runs on one timeline: what each recorded under a name of its own, on the one axis of frames, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np

from app.render.viewpoint import from_above, overview
from app.run_folder.mapped_run import MappedRun, read_run
from app.run_folder.run_folder import TIMELINE
from app.timeline.entities import OBJECTS, POSE_EVENTS, SIGMA
from app.timeline.objects.object_history import entity_names
from app.timeline.pose_figures import pose_figures, world_from_other
from app.timeline.recording.layout import RunView, pair_layout
from app.timeline.recording.saved_recording import RunStyle, SavedRecording, write_merged
from razer.errors import BadInput
from razer.storage.atomic_files import replace_file

PATH_COLORS = [(31, 111, 180), (255, 140, 0)]


def write_side_by_side(path: Path, runs: Sequence[Path]) -> None:
    """Write the timelines of runs, which are named by their folders, as one recording, in the world of the first;
    raises BadInput."""
    names = _distinct_names(runs)
    for run in runs:
        if not (run / TIMELINE).is_file():
            raise BadInput(f"{run / TIMELINE} does not exist; runs side by side need one each, made with --timeline")
    recordings = [SavedRecording(run / TIMELINE) for run in runs]
    mapped = [read_run(run) for run in runs]
    views = [(name, _view(run, name, data)) for name, run, data in zip(names, mapped, recordings, strict=True)]
    moved = [recording.under(name) for name, recording in zip(names, recordings, strict=True)]
    # In turn, so that a viewer shows both early.
    chunks = [chunk for pair in zip_longest(*moved) for chunk in pair if chunk is not None]
    motions = [world_from_other(mapped[0], run) for run in mapped]
    styles = {name: RunStyle(motion, color) for name, motion, color in zip(names, motions, PATH_COLORS, strict=False)}
    figures = pose_figures(dict(zip(names, mapped, strict=True)), recordings[0].depth_images())
    replace_file(path, lambda target: write_merged(target, chunks, pair_layout(views), styles, figures))


def _distinct_names(runs: Sequence[Path]) -> list[str]:
    names = [run.absolute().name for run in runs]
    return names if len(set(names)) == len(names) else [f"{name}_{n}" for n, name in enumerate(names, start=1)]


def _view(mapped: MappedRun, name: str, recording: SavedRecording) -> RunView:
    points, up = mapped.panoptic.mesh.vertices.astype(np.float64), mapped.panoptic.up_or_z
    poses = np.eye(4)[None] if mapped.trajectory is None else mapped.trajectory.world_from_camera.astype(np.float64)
    forward = poses[:, :3, 2].mean(axis=0)
    eye = overview(points if len(points) else poses[:, :3, 3], up, forward)
    stuff = {item.id: item.class_name for item in mapped.panoptic.objects if item.is_stuff}
    hidden = tuple(f"{OBJECTS}/{entity}" for entity in entity_names(stuff).values())
    instances = mapped.panoptic.mesh.instances
    of_things = points[~np.isin(instances, [0, *stuff])]
    objects_eye = overview(of_things, up, forward) if len(of_things) else eye
    estimated = recording.holds(SIGMA) or recording.holds(POSE_EVENTS)
    top = from_above(poses[:, :3, 3], up, forward)
    return RunView(eye, top, objects_eye, estimated, hidden=hidden, root=f"/{name}")
