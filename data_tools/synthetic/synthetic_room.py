"""A synthetic room as a sequence of RGB-D frames with poses, instance ids and ground truth."""

from __future__ import annotations

from functools import partial
from typing import Any

from data_tools.synthetic.camera.hand_held import walk_round
from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S
from data_tools.synthetic.rendered_sequence import CAMERA, Move, RenderedSequence
from data_tools.synthetic.scenes.living_room import living_room
from razer.errors import BadInput

__all__ = ["FRAMES_PER_S", "SyntheticRoom"]

_RADII_M = (1.75, 1.3)


class SyntheticRoom(RenderedSequence):
    """A room rendered on demand; frames are a pure function of the arguments and the index.

    Args:
        seed: varies colours, furniture and the hand that holds the camera.
        n_frames: at 15 a second.
        width: of the images, pixels.
        height: of the images, pixels.
        moved: puts one chair about a metre away in the middle of the recording, which then shows the same views
            before and after.
        noise: short for SensorModel.plain().
        sensor: what its images suffer; None = by `noise`.
        misalignment: how the true colour camera differs from the declared one; None = not at all.

    Raises:
        BadInput: for an empty recording.
    """

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
        misalignment: RgbdMisalignment | None = None,
    ) -> None:
        if n_frames < 1:
            raise BadInput(f"a recording of {n_frames} frames is impossible: ask for at least 1")
        sensor = sensor or (SensorModel.plain() if noise else SensorModel.none())
        options: dict[str, Any] = {"moved": moved, "sensor": sensor, "misalignment": misalignment}
        layout = living_room(seed)
        super().__init__(
            f"synthetic-room-{seed}",
            layout.things,
            walk_round(n_frames, _RADII_M, seed, look_out=not moved),
            CAMERA.resized(width, height),
            sensor,
            seed,
            partial(SyntheticRoom, seed, n_frames, width, height, **options),
            relations=layout.relations,
            move=Move(layout.movable, n_frames // 2, layout.elsewhere) if moved else None,
            misalignment=misalignment,
        )
