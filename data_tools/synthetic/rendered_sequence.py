"""Rendered RGB-D sequence of a synthetic world: frames with poses and instance ids on demand, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S
from data_tools.synthetic.layout.arrangement import Triple
from data_tools.synthetic.light.emitters import Light
from data_tools.synthetic.people.peopled_view import FilmedWalker, PeopledView
from data_tools.synthetic.people.walkers import Walker
from data_tools.synthetic.rendered_frames import CAMERA, RenderedFrames
from data_tools.synthetic.rendering.ray_renderer import RayRenderer
from data_tools.synthetic.rendering.rgbd_renderer import Renderer
from data_tools.synthetic.shapes.thing import Thing
from data_tools.synthetic.truth.tessellation import affordable_spacing_m
from data_tools.synthetic.truth.true_surface import ground_truth
from data_tools.synthetic.truth.visibility import CameraView, Viewpoint
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import Float64Array
from razer.frame import Intrinsics

__all__ = ["CAMERA", "Move", "RenderedSequence"]


@dataclass(frozen=True, slots=True)
class Move:
    """An instance that changes its place: the first frame in which it stands at its new one, and it there."""

    instance: int
    frame: int
    thing: Thing


class RenderedSequence(RenderedFrames):
    """A recording of things along a camera path; frames are a pure function of the arguments and the index.

    Args:
        name: what to call the recording.
        things: instance id -> Thing.
        poses: (N, 4, 4) world_from_camera.
        camera: of depth, and declared for colour too.
        sensor: what its images suffer.
        seed: of textures and of the sensor.
        made_by: makes the same sequence again, in another process.
        move: an instance that changes its place; None = none.
        relations: how the things were placed, for the truth.
        frames_per_s: of the stamps.
        misalignment: how the true colour camera differs from the declared one; None = not at all.
        light: the time of day.
        walkers: people who walk about; none of them is in the truth, but what they hide is not seen.
        earlier: (N, 4, 4) where the camera was 1/15 s before each frame; None = in the frame before.
    """

    def __init__(
        self,
        name: str,
        things: Mapping[int, Thing],
        poses: Float64Array,
        camera: Intrinsics,
        sensor: SensorModel,
        seed: int,
        made_by: Callable[[], RenderedFrames],
        *,
        move: Move | None = None,
        relations: tuple[Triple, ...] = (),
        frames_per_s: float = FRAMES_PER_S,
        misalignment: RgbdMisalignment | None = None,
        light: Light = "even",
        walkers: Sequence[Walker] = (),
        earlier: Float64Array | None = None,
    ) -> None:
        super().__init__(
            name,
            poses,
            camera,
            sensor,
            seed,
            made_by,
            frames_per_s=frames_per_s,
            misalignment=misalignment,
            earlier=earlier,
        )
        self.move = move
        self._light = light
        self._walkers = [FilmedWalker(walker, camera, seed, light) for walker in walkers]
        self._relations = relations
        self._final = {**things, move.instance: move.thing} if move else things
        self._before = self._renderer(things)
        self._after = self._renderer(self._final) if move else self._before
        self._classes = {number: thing.class_name for number, thing in self._final.items()}

    @property
    def classes(self) -> Mapping[int, str]:
        """The class name of each instance id."""
        return self._classes

    def truth_spacing_m(self, wanted_m: float) -> float:
        """How far apart the vertices of the truth are: as wanted, or farther in a world that is too large for that."""
        return affordable_spacing_m(self._final, wanted_m)

    def truth(self, spacing_m: float = 0.01, range_m: tuple[float, float] = (0.1, 5.0)) -> GroundTruth:
        """The surface as it is at the end, sampled as `truth_spacing_m` says; visible = seen within range_m
        (metres along the optical axis) in at least 3 frames."""
        spacing_m = self.truth_spacing_m(spacing_m)
        viewpoints = [Viewpoint(pose, self._renderer_at(i).scene) for i, pose in enumerate(self._poses)]
        late = {self.move.instance: self.move.frame} if self.move else {}
        truth = ground_truth(self._final, viewpoints, CameraView(self.intrinsics, range_m), spacing_m, late)
        return replace(truth, rgbd_calibration=self.calibration, relations=self._relations)

    def _renderer(self, things: Mapping[int, Thing]) -> Renderer:
        return self._seen_by(lambda camera: RayRenderer(things, camera, self._seed, self._light))

    def _renderer_at(self, index: int) -> Renderer:
        still = self._after if self.move and index >= self.move.frame else self._before
        return PeopledView(still, self._walkers, index / self._frames_per_s) if self._walkers else still
