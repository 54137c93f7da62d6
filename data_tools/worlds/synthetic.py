"""A synthetic room as a sequence of RGB-D frames with poses, instance ids and ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from data_tools.truth.ground_truth import GroundTruth
from data_tools.worlds.camera_path import walk_round
from data_tools.worlds.living_room import living_room
from data_tools.worlds.ray_renderer import RayRenderer
from data_tools.worlds.sensor_model import SensorModel
from data_tools.worlds.true_surface import ground_truth
from data_tools.worlds.visibility import Vantage, View
from razer.frame import BadInput, Frame, Intrinsics

FRAMES_PER_S = 15.0
_CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
_RADII_M = (1.75, 1.3)


@dataclass(frozen=True, slots=True)
class Move:
    """An instance that changes its place: the first frame in which it stands at its new one."""

    instance: int
    frame: int


class SyntheticRoom:
    """A room rendered on demand; frames are a pure function of the arguments and the index.

    seed varies colours, furniture and the hand that holds the camera; `moved` puts one chair about a metre away in
    the middle of the recording, which then shows the same views before and after; `sensor` is what looks at it,
    `noise` short for SensorModel.plain(). Raises BadInput for an empty recording."""

    has_poses = True
    depth_scale = 1.0

    def __init__(
        self,
        seed: int = 0,
        n_frames: int = 240,
        width: int = 640,
        height: int = 480,
        *,
        moved: bool = False,
        noise: bool = False,
        sensor: SensorModel | None = None,
    ) -> None:
        if n_frames < 1:
            raise BadInput(f"a recording of {n_frames} frames is impossible: ask for at least 1")
        self.name = f"synthetic-room-{seed}"
        self.intrinsics = _CAMERA.resized(width, height)
        self._seed = seed
        self._sensor = sensor or (SensorModel.plain() if noise else SensorModel.none())
        self._made_by = partial(SyntheticRoom, seed, n_frames, width, height, moved=moved, sensor=self._sensor)
        self._layout = living_room(seed)
        self.move = Move(self._layout.movable, n_frames // 2) if moved else None
        self._poses = walk_round(n_frames, _RADII_M, seed, look_out=not moved)
        self._before = RayRenderer(self._layout.things, self.intrinsics, seed)
        after = self._layout.after_move() if moved else self._layout
        self._after = RayRenderer(after.things, self.intrinsics, seed) if moved else self._before
        self._final = after
        self.classes = {number: thing.class_name for number, thing in after.things.items()}

    def __reduce__(self) -> tuple[partial[SyntheticRoom], tuple[()]]:
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
        return Frame(index, index / FRAMES_PER_S, rgb, depth, self.intrinsics, pose.copy(), ids, dict(self.classes))

    def truth(self, spacing_m: float = 0.01, range_m: tuple[float, float] = (0.1, 5.0)) -> GroundTruth:
        """The surface as it is at the end, sampled every spacing_m metres; visible = seen within range_m
        (metres along the optical axis) in at least 3 frames."""
        vantages = [Vantage(pose, self._renderer_at(i).scene) for i, pose in enumerate(self._poses)]
        late = {self.move.instance: self.move.frame} if self.move else {}
        return ground_truth(self._final.things, vantages, View(self.intrinsics, range_m), spacing_m, late)

    def _renderer_at(self, index: int) -> RayRenderer:
        return self._after if self.move and index >= self.move.frame else self._before
