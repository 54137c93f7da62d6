"""Rendered RGB-D sequence of a synthetic world: frames with poses and instance ids on demand, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from data_tools.recordings.sequence import FrameIteration
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S
from data_tools.synthetic.layout.arrangement import Triple
from data_tools.synthetic.rendering.ray_renderer import RayRenderer
from data_tools.synthetic.shapes.thing import Thing
from data_tools.synthetic.truth.true_surface import ground_truth
from data_tools.synthetic.truth.visibility import CameraView, Viewpoint
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import Float64Array
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)


@dataclass(frozen=True, slots=True)
class Move:
    """An instance that changes its place: the first frame in which it stands at its new one, and it there."""

    instance: int
    frame: int
    thing: Thing


class RenderedSequence(FrameIteration):
    """A recording of things along a camera path; frames are a pure function of the arguments and the index.

    Args:
        name: what to call the recording.
        things: instance id -> Thing.
        poses: (N, 4, 4) world_from_camera.
        camera: of colour and depth.
        sensor: what its images suffer.
        seed: of textures and of the sensor.
        made_by: makes the same sequence again, in another process.
        move: an instance that changes its place; None = none.
        relations: how the things were placed, for the truth.
        frames_per_s: of the stamps.
    """

    has_poses = True
    depth_scale = 1.0

    def __init__(
        self,
        name: str,
        things: Mapping[int, Thing],
        poses: Float64Array,
        camera: Intrinsics,
        sensor: SensorModel,
        seed: int,
        made_by: Callable[[], RenderedSequence],
        *,
        move: Move | None = None,
        relations: tuple[Triple, ...] = (),
        frames_per_s: float = FRAMES_PER_S,
    ) -> None:
        self.name = name
        self.intrinsics = camera
        self.move = move
        self._relations = relations
        self._poses = poses
        self._sensor = sensor
        self._seed = seed
        self._made_by = made_by
        self._frames_per_s = frames_per_s
        self._final = {**things, move.instance: move.thing} if move else things
        self._before = RayRenderer(things, camera, seed)
        self._after = RayRenderer(self._final, camera, seed) if move else self._before
        self.classes = {number: thing.class_name for number, thing in self._final.items()}

    def __reduce__(self) -> tuple[Callable[[], RenderedSequence], tuple[()]]:
        # A ray caster cannot be sent to another process, but made again there.
        return self._made_by, ()

    def __len__(self) -> int:
        return len(self._poses)

    def __getitem__(self, index: int) -> Frame:
        """Render one frame; raises IndexError outside the recording."""
        if not 0 <= index < len(self):
            raise IndexError(f"frame {index} of {len(self)}")
        pose = self._poses[index]
        rgb, depth, ids = self._renderer_at(index).render(pose)
        rgb, depth = self._sensor.observe(rgb, depth, self.intrinsics, self._poses, index=index, seed=self._seed)
        stamp = index / self._frames_per_s
        return Frame(index, stamp, rgb, depth, self.intrinsics, pose.copy(), ids, dict(self.classes))

    def truth(self, spacing_m: float = 0.01, range_m: tuple[float, float] = (0.1, 5.0)) -> GroundTruth:
        """The surface as it is at the end, sampled every spacing_m metres; visible = seen within range_m
        (metres along the optical axis) in at least 3 frames."""
        viewpoints = [Viewpoint(pose, self._renderer_at(i).scene) for i, pose in enumerate(self._poses)]
        late = {self.move.instance: self.move.frame} if self.move else {}
        truth = ground_truth(self._final, viewpoints, CameraView(self.intrinsics, range_m), spacing_m, late)
        return replace(truth, relations=self._relations)

    def _renderer_at(self, index: int) -> RayRenderer:
        return self._after if self.move and index >= self.move.frame else self._before
