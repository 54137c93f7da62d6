"""What a keyframe costs in a map of many, and how large its view is: `python -m tests.slam.long_map_cost [AISLE_M [SIZE
...]]`.

A walk up and down the aisles of a large hall is made up, whose keyframes all show one and the same view; only what
tracking and place recognition cost is left out, which do not depend on how many there are. With aisles 4 m apart no
view shows what another aisle's did; 0.5 m apart each does, and the pose graph is one great grid of loops, the worst
there is.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from time import process_time
from unittest.mock import patch

import numpy as np

from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.loop_closure import LoopClosure
from slam.backend.place_recognition import PlaceRecognition
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import STILL, View
from slam.pose_edge import EDGE_SHARE, PoseEdge
from slam.se3 import exp_se3
from slam.system import SlamSystem

SIZES = (50, 500, 5000)
SPACING_M, AISLE_M, AISLE_KEYFRAMES = 0.2, 4.0, 60
NOISE = 2e-3  # radians and metres, of a motion from one keyframe to the next
FRAMES_PER_KEYFRAME = 4
AVERAGED = 20  # keyframes


class Walk:
    """A map that grows along the walk, with edges as they would be measured."""

    def __init__(self, view: View, aisle_m: float) -> None:
        self.aisle_m = aisle_m
        self.slam, self.rng, self.view = SlamSystem(), np.random.default_rng(0), view
        self.seconds: dict[str, float] = {}
        self.slam.map.begin_submap(view, 0.0)

    def pose(self, number: int) -> Float64Array:
        """Where the keyframe of a number is: to and fro along aisles, always looking the same way."""
        aisle, along = divmod(number, AISLE_KEYFRAMES)
        place = along if aisle % 2 == 0 else AISLE_KEYFRAMES - 1 - along
        return exp_se3(np.array([0, 0, 0, SPACING_M * place, 0, self.aisle_m * aisle]))

    def measured(self, a: int, b: int) -> Float64Array:
        """The motion between two keyframes with an error."""
        return inverse(self.pose(a)) @ self.pose(b) @ exp_se3(self.rng.normal(0, NOISE, 6))

    def grow(self) -> None:
        """One further keyframe, and what comes with it."""
        slam, number = self.slam, len(self.slam.keyframes)
        information = np.eye(6) / NOISE**2 / EDGE_SHARE
        measured, nominal = self.measured(number - 1, number), ColorCalibration.nominal()
        result = IcpResult(measured, information, information, 0.6, 0.9, 0.6, 1.0, 200, nominal)
        view = replace(self.view, index=FRAMES_PER_KEYFRAME * number)
        self._timed("extend", lambda: slam.map.extend(slam.keyframes[number - 1], view, result, SPACING_M * number))
        for frame in range(FRAMES_PER_KEYFRAME):
            slam._located.add(FRAMES_PER_KEYFRAME * number + frame, slam.keyframes[number], np.eye(4))
            self._timed("choose pairs", lambda: slam.map.close_loops(ColorCalibration.nominal(), 1))
        self._timed("corrections", slam.corrections)
        self._timed("report", slam.report)

    def _timed(self, name: str, work: Callable[[], object]) -> None:
        start_s = process_time()
        work()
        self.seconds[name] = self.seconds.get(name, 0.0) + process_time() - start_s


def view_bytes(view: View) -> dict[str, int]:
    """The bytes of a keyframe's view at rest by its parts."""
    features, wide = vars(view.features).values(), vars(view.wide.features).values()
    colors = {id(part): held(part) for part in (view.sparse.rgb, view.sparse.has_color, view.sparse.recorded_rgb)}
    view.pyramid.release()
    return {
        "depth to register": view.pyramid.n_bytes,
        "sparse depth": view.sparse.depth.nbytes,
        "sparse colour": sum(colors.values()),
        f"{len(view.features)} ORB features": sum(map(held, features)),
        f"{len(view.wide.features)} SIFT features": sum(map(held, wide)),
    }


def held(part: object) -> int:
    """The bytes that an array holds: one entry, where all are that one; no other value has any to speak of."""
    if not isinstance(part, np.ndarray):
        return 0
    return part.nbytes if any(part.strides) else part.itemsize


def main(aisle_m: float, sizes: tuple[int, ...]) -> None:
    """Print the milliseconds of the last keyframes before each size."""
    config = SlamConfig()
    frame = SyntheticScene("room", 3, 60, sensor=SensorModel.kinect())[10]
    features = FeatureExtractor(config).extract(frame, ColorCalibration.nominal())
    view = View.of(frame, features, STILL, config)
    parts = view_bytes(view)
    told = ", ".join(f"{name} {size / 1e3:.1f}" for name, size in parts.items())
    print(f"a view keeps {sum(parts.values()) / 1e3:.1f} kB: {told}", flush=True)
    walked = Walk(view, aisle_m)

    def measure_next(loops: LoopClosure, calibration: ColorCalibration) -> PoseEdge | None:
        pair = loops._next()
        if pair is None:
            return None
        a, b = (keyframe.number for keyframe in pair)
        return PoseEdge(a, b, walked.measured(a, b), np.eye(6) / NOISE**2 / EDGE_SHARE)

    unknown = patch.multiple(PlaceRecognition, add=lambda self, view: None, lookalikes=lambda self, *asked: [])
    with patch.object(LoopClosure, "measure_next", measure_next), unknown:
        for size in sizes:
            while len(walked.slam.keyframes) < size - AVERAGED:
                walked.grow()
            walked.seconds.clear()
            while len(walked.slam.keyframes) < size:
                walked.grow()
            parts = {name: 1e3 * seconds / AVERAGED for name, seconds in walked.seconds.items()}
            told = ", ".join(f"{name} {ms:.1f}" for name, ms in parts.items())
            n_edges = len(walked.slam.graph.edges)
            print(f"{size} keyframes, {n_edges} edges: {sum(parts.values()):.1f} ms a keyframe ({told})", flush=True)


if __name__ == "__main__":
    aisle, *numbers = sys.argv[1:] or [str(AISLE_M)]
    main(float(aisle), tuple(int(number) for number in numbers) or SIZES)
