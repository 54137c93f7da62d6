"""Frames of a simulated RGB-D camera along a path, rendered on demand and sent to other processes by how they are
made."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from data_tools.recordings.sequence import FrameIteration
from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.rendering.rgbd_renderer import Renderer, RgbdRenderer
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import Float64Array
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)


class RenderedFrames(FrameIteration, ABC):
    """A recording whose frames are a pure function of the arguments and the index.

    Args:
        name: what to call the recording.
        poses: (N, 4, 4) world_from_camera.
        camera: of depth, and declared for colour too.
        sensor: what its images suffer.
        seed: of the sensor.
        made_by: makes the same sequence again, in another process.
        frames_per_s: of the stamps.
        misalignment: how the true colour camera differs from the declared one; None = not at all.
        earlier: (N, 4, 4) where the camera was 1/15 s before each frame, for motion blur; None = in the frame before.
    """

    has_poses = True
    depth_scale = 1.0

    def __init__(
        self,
        name: str,
        poses: Float64Array,
        camera: Intrinsics,
        sensor: SensorModel,
        seed: int,
        made_by: Callable[[], RenderedFrames],
        *,
        frames_per_s: float,
        misalignment: RgbdMisalignment | None = None,
        earlier: Float64Array | None = None,
    ) -> None:
        self.name = name
        self.intrinsics = camera
        self._poses = poses
        self._earlier = earlier
        self._sensor = sensor
        self._seed = seed
        self._made_by = made_by
        self._frames_per_s = frames_per_s
        planted = misalignment or RgbdMisalignment()
        self.calibration = None if planted.is_none else planted.calibration(camera)

    def __reduce__(self) -> tuple[Callable[[], RenderedFrames], tuple[()]]:
        # A ray caster cannot be sent to another process, but made again there.
        return self._made_by, ()

    def __len__(self) -> int:
        return len(self._poses)

    def __getitem__(self, index: int) -> Frame:
        """Render one frame; raises IndexError outside the recording."""
        if not 0 <= index < len(self):
            raise IndexError(f"frame {index} of {len(self)}")
        pose = self._poses[index]
        rgb, depth, ids, parts = self._renderer_at(index).render(pose)
        before = None if self._earlier is None else self._earlier[index]
        rgb, depth = self._sensor.observe(
            rgb, depth, self.intrinsics, self._poses, index=index, seed=self._seed, before=before
        )
        stamp = index / self._frames_per_s
        names = dict(self.classes)
        return Frame(index, stamp, rgb, depth, self.intrinsics, pose.copy(), ids, names, part_ids=parts)

    @property
    def poses(self) -> Float64Array:
        """world_from_camera (N, 4, 4) of all frames, which takes no rendering."""
        return self._poses

    @property
    def notes(self) -> tuple[str, ...]:
        """What one should know of how the recording was made, in words."""
        return ()

    @property
    def summary(self) -> Mapping[str, Any]:
        """What the summary of this kind of recording says beyond counts, as JSON has it."""
        return {} if self.calibration is None else {"rgbd_calibration": self.calibration.to_json()}

    @property
    @abstractmethod
    def classes(self) -> Mapping[int, str]:
        """The class name of each instance id."""

    def truth_spacing_m(self, wanted_m: float) -> float:
        """How far apart the vertices of the truth are, metres; a mesh keeps its own."""
        return wanted_m

    @abstractmethod
    def truth(self, spacing_m: float = 0.01, range_m: tuple[float, float] = (0.1, 5.0)) -> GroundTruth:
        """The labelled surface; visible = seen within range_m (metres along the optical axis) in at least 3 frames.

        spacing_m: between sampled vertices, where the surface has none of its own."""

    @abstractmethod
    def _renderer_at(self, index: int) -> Renderer: ...

    def _seen_by(self, make: Callable[[Intrinsics], Renderer]) -> Renderer:
        """The renderer of this recording's cameras: the depth camera, and the colour camera if it is another."""
        if self.calibration is None:
            return make(self.intrinsics)
        return RgbdRenderer(make, self.intrinsics, self.calibration)
