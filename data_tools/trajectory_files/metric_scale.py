"""Metric scale of poses from images alone, whose unit is any: the one at which depth images, seen from where others
were taken, agree best.

Features would have to lie on the right depth, which colour that is not registered keeps them from; depth alone asks
nothing of colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.sequence import RgbdSequence
from data_tools.trajectory_files.frame_poses import FramePoses
from razer.arrays import Float64Array
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.geometry import back_project, inverse, project, transform_points

AS_WRITTEN = 0.05  # scales that differ by less from 1 are those of metres: phones err by a few per cent, too
MAX_FRAMES, MAX_PAIRS, MIN_PAIRS = 24, 80, 12
MAX_TURN_DEG = 30.0  # of a pair: beyond, little is seen by both
MAX_POINTS_ALONG = 48  # of a depth image's longer edge
OTHER_SURFACE_M = 0.1  # farther apart two readings are of two surfaces, or of nothing
FEWEST_READINGS = 100  # of a pair
COARSE, FINE = np.geomspace(5e-4, 2e3, 151), np.exp(np.linspace(-0.25, 0.25, 51))
QUARTERS, MAX_SPREAD = 4, 0.03  # each of so many parts of the pairs must have its best scale that near, as a share


def in_metres(sequence: RecordedSequence, found: FramePoses) -> tuple[FramePoses, str]:
    """Poses in metres, and what was done to bring them there. Those whose unit is a metre by depth, and those of which
    it tells nothing, stay as they are."""
    scale = _scale_by_depth(_posed_frames(replace(sequence, pose_of=found, implausible={}), sorted(found.poses)))
    if scale is None:
        return found, "taken as metres: depth does not tell their scale"
    if abs(scale - 1) <= AS_WRITTEN:
        return found, "in metres, as depth confirms"
    scaled = {frame: _scaled(pose, scale) for frame, pose in found.poses.items()}
    return replace(found, poses=scaled), f"multiplied by {scale:.3g} to be metres, as depth has it"


def from_depth_camera(found: FramePoses, color_from_depth: Float64Array | None) -> FramePoses:
    """The poses of the depth camera beside the colour camera whose images the poses are of."""
    if color_from_depth is None:
        return found
    return replace(found, poses={frame: pose @ color_from_depth for frame, pose in found.poses.items()})


def _scaled(pose: Float64Array, scale: float) -> Float64Array:
    scaled = pose.copy()
    scaled[:3, 3] *= scale
    return scaled


def _posed_frames(sequence: RgbdSequence, posed: Sequence[int]) -> list[Frame]:
    """Usable frames spread over those that have a pose."""
    frames = []
    for row in dict.fromkeys(np.linspace(0, len(posed) - 1, MAX_FRAMES).round().astype(int).tolist()):
        try:
            frames.append(sequence[posed[row]])
        except UnusableFrame:
            continue
    return frames


@dataclass(frozen=True)
class _Pair:
    """Points (N, 3) of one frame, another frame, and the motion to it as its poses have it."""

    points: Float64Array
    other: Frame
    other_from_points: Float64Array

    def apart_m(self, scale: float, outside_m: float) -> float:
        """How far apart the depths of both are on average with the motion scaled, points outside the other image
        counting as so far; nan where too few are inside."""
        camera, moved = self.other.intrinsics, _scaled(self.other_from_points, scale)
        u, v, z = project(transform_points(moved, self.points), camera.matrix)
        inside = (u > -0.5) & (u < camera.width - 0.5) & (v > -0.5) & (v < camera.height - 0.5)
        read = self.other.depth[np.rint(v[inside]).astype(int), np.rint(u[inside]).astype(int)]
        apart = np.minimum(np.abs(read - z[inside])[read > 0], OTHER_SURFACE_M)
        if np.isfinite(outside_m):
            n_outside = int((~inside).sum())
            return float((apart.sum() + outside_m * n_outside) / max(len(apart) + n_outside, 1))
        return float(apart.mean()) if len(apart) >= FEWEST_READINGS else float("nan")


def _pairs(frames: Sequence[Frame]) -> list[_Pair]:
    """Pairs that look much the same way, of these the half that is farther apart."""
    points = [_points(frame) for frame in frames]
    motions = {(a, b): inverse(frames[b].pose) @ frames[a].pose for a, b in permutations(range(len(frames)), 2)}
    cosine = np.cos(np.radians(MAX_TURN_DEG))
    alike = [pair for pair, motion in motions.items() if (np.trace(motion[:3, :3]) - 1) / 2 > cosine]
    apart = sorted(alike, key=lambda pair: float(np.linalg.norm(motions[pair][:3, 3])))[len(alike) // 2 :]
    chosen = apart[:: len(apart) // MAX_PAIRS + 1]
    return [_Pair(points[a], frames[b], motions[a, b]) for a, b in chosen if motions[a, b][:3, 3].any()]


def _points(frame: Frame) -> Float64Array:
    step = -(-max(frame.depth.shape) // MAX_POINTS_ALONG)
    v, u = step * np.array(np.nonzero(frame.depth[::step, ::step]))
    return back_project(u, v, frame.depth[v, u], frame.intrinsics.matrix)


def _scale_by_depth(frames: Sequence[Frame]) -> float | None:
    """The scale of the poses' positions at which depth agrees best; None where parts of the pairs disagree on it."""
    pairs = _pairs(frames)
    if len(pairs) < MIN_PAIRS:
        return None
    about = COARSE[np.argmin([sum(pair.apart_m(scale, OTHER_SURFACE_M) for pair in pairs) for scale in COARSE])]
    apart_m = np.array([[pair.apart_m(about * share, np.inf) for share in FINE] for pair in pairs])
    apart_m = apart_m[np.isfinite(apart_m).all(axis=1)]
    if len(apart_m) < MIN_PAIRS:
        return None
    best = FINE[int(apart_m.mean(axis=0).argmin())]
    of_parts = [FINE[int(apart_m[part::QUARTERS].mean(axis=0).argmin())] for part in range(QUARTERS)]
    is_sure = max(abs(np.log(np.array(of_parts) / best))) <= MAX_SPREAD and FINE[0] < best < FINE[-1]
    return float(about * best) if is_sure else None
