"""Which share of pairs of pictures that share much is registered rightly, by how far apart they are, and how many wrong
motions are believed, of pairs that share nothing, too.

python -m tests.slam.wide_pairs redkitchen room:1 apartment:2
"""

from __future__ import annotations

import sys
from collections import defaultdict
from os import environ
from pathlib import Path
from time import process_time

import numpy as np

from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.geometry import inverse
from slam.backend.view_overlap import overlap_of, reading_points
from slam.config import SlamConfig
from slam.se3 import angle_deg, length_m
from slam.sparse.picture_matching import PictureMatching
from slam.sparse.sparse_system import picture_view

N_PICTURES, N_PAIRS = 120, 40  # spread over the recording; of each kind
MAX_M, MAX_DEG, MIN_OVERLAP = 0.5, 30.0, 0.4
RIGHT_M, RIGHT_DEG, FALSE_M, FALSE_DEG = 0.05, 2.5, 0.15, 6.0
NO_OVERLAP = 0.02


def opened(name):
    scene, _, seed = name.partition(":")
    if seed:
        return SyntheticScene(scene, int(seed), None, 320, 240, sensor=SensorModel.kinect())
    return open_sequence(Path(environ["RAZER_TEST_DATA"]) / "data" / scene)


def pictures(sequence, config):
    indices = np.unique(np.linspace(0, len(sequence) - 1, N_PICTURES).astype(int)).tolist()
    frames = [sequence[index] for index in indices]
    return [picture_view(frame, config) for frame in frames], [frame.pose for frame in frames]


def kinds(views, poses, config):
    """Pairs by kind: how far apart, of those that overlap; "apart" for those that share nothing."""
    points = [reading_points(view, config.depth.max_depth_m) for view in views]
    found = defaultdict(list)
    for a in range(len(views)):
        for b in range(a + 1, len(views)):
            a_from_b = inverse(poses[a]) @ poses[b]
            shift, turn = length_m(a_from_b), angle_deg(a_from_b)
            near = shift <= MAX_M and turn <= MAX_DEG
            if not near and (a * 7 + b) % 5:
                continue
            overlap = min(overlap_of(points[b], views[a], a_from_b), overlap_of(points[a], views[b], inverse(a_from_b)))
            if near and overlap >= MIN_OVERLAP:
                kind = f"{'<' if shift < MAX_M / 2 else '>'}25cm {'<' if turn < MAX_DEG / 2 else '>'}15deg"
                found[kind].append((a, b))
            elif overlap <= NO_OVERLAP and not near:
                found["apart"].append((a, b))
    return found


def main(name):
    config = SlamConfig()
    views, poses = pictures(opened(name), config)
    matching = PictureMatching(views, config)
    matching.learn_camera()
    rng = np.random.default_rng(0)
    for kind, pairs in sorted(kinds(views, poses, config).items()):
        chosen = [pairs[n] for n in rng.permutation(len(pairs))[: N_PAIRS * (4 if kind == "apart" else 1)]]
        started_s, verdicts, features = process_time(), defaultdict(int), []
        for a, b in chosen:
            keyframe, view = matching.keyframes[a], matching.keyframes.view(matching.keyframes[b])
            result = matching.registration.recognise(keyframe, view, [], matching.calibration)
            if result is None:
                verdicts["none"] += 1
                continue
            off = inverse(inverse(poses[a]) @ poses[b]) @ result.target_from_source
            off_m, off_deg = length_m(off), angle_deg(off)
            right = off_m <= RIGHT_M and off_deg <= RIGHT_DEG
            verdict = "right" if right else "false" if off_m > FALSE_M or off_deg > FALSE_DEG else "rough"
            verdicts[verdict] += 1
            if verdict == "false":
                features.append((a, b, result.n_features, round(result.score, 2), round(off_m, 2), round(off_deg)))
        ms = 1000 * (process_time() - started_s) / max(len(chosen), 1)
        print(f"{name:14s} {kind:15s} n={len(chosen):3d} {dict(verdicts)} {ms:.0f} ms a pair {features}", flush=True)


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        main(argument)
