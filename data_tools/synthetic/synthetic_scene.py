"""Synthetic scenes by name: the recording of a seeded world along its walk."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S, usual_frames, walk
from data_tools.synthetic.layout.finishes import Walls, with_walls
from data_tools.synthetic.light.emitters import Light
from data_tools.synthetic.people.walkers import walkers
from data_tools.synthetic.rendered_sequence import CAMERA, RenderedSequence
from data_tools.synthetic.scenes import corridors as office
from data_tools.synthetic.scenes import warehouse as store
from data_tools.synthetic.scenes.apartment import apartment
from data_tools.synthetic.scenes.corridor_loop import corridor_loop
from data_tools.synthetic.scenes.single_room import single_room
from data_tools.synthetic.scenes.tabletop import tabletop
from data_tools.synthetic.scenes.twin_rooms import twin_rooms
from data_tools.synthetic.scenes.world import World
from razer.errors import BadInput

SCENES: dict[str, Callable[[int], World]] = {
    "room": single_room,
    "apartment": apartment,
    "corridor-loop": corridor_loop,
    "tabletop": tabletop,
    "warehouse": store.warehouse,
    "corridors": office.corridors,
    "twin-rooms": twin_rooms,
}
# Scenes of any size, and the least length and width of them, metres.
SIZED: dict[str, tuple[Callable[[int, tuple[float, float]], World], tuple[float, float]]] = {
    "warehouse": (store.warehouse, store.LEAST_M),
    "corridors": (office.corridors, office.LEAST_M),
}
MOST_M = 200.0


class SyntheticScene(RenderedSequence):
    """One of SCENES rendered on demand; frames are a pure function of the arguments and the index.

    Stamps are those of a hand-held camera, however many frames there are.

    Args:
        scene: a name in SCENES.
        seed: varies what stands where, colours and the hand that holds the camera.
        n_frames: spread evenly over the whole walk; None or 0 = as many as make 15 frames/s.
        width: of the images, pixels.
        height: of the images, pixels.
        sensor: what its images suffer; None = nothing.
        misalignment: how the true colour camera differs from the declared one; None = not at all.
        light: the time of day.
        extent_m: length and width, metres, of a scene in SIZED; None = its usual size.
        people: how many walk about; they are in the frames, as nobody, and not in the truth.
        walls: the finish of walls and ceilings.

    Raises:
        BadInput: for an unknown scene or a recording of fewer than 0 frames, a size that a scene cannot have, or people
            before two cameras.
    """

    def __init__(
        self,
        scene: str,
        seed: int = 0,
        n_frames: int | None = None,
        width: int = 640,
        height: int = 480,
        *,
        sensor: SensorModel | None = None,
        misalignment: RgbdMisalignment | None = None,
        light: Light = "day",
        extent_m: tuple[float, float] | None = None,
        people: int = 0,
        walls: Walls = "painted",
    ) -> None:
        if scene not in SCENES:
            raise BadInput(f"unknown scene '{scene}': choose one of {', '.join(SCENES)}")
        if seed < 0:
            raise BadInput(f"seed {seed} is negative: give 0 or more")
        if n_frames is not None and n_frames < 0:
            raise BadInput(f"a recording of {n_frames} frames is impossible: ask for at least 1")
        if people and misalignment is not None and not misalignment.is_none:
            raise BadInput("people are seen by one camera only: leave them out, or the other colour camera")
        sensor = sensor or SensorModel.none()
        world = _world(scene, seed, extent_m)
        usual = usual_frames(world.stations)
        count = n_frames or usual
        rate = FRAMES_PER_S * max(count - 1, 1) / (usual - 1)
        options: dict[str, Any] = {"sensor": sensor, "misalignment": misalignment, "light": light}
        options |= {"extent_m": extent_m, "people": people, "walls": walls}
        poses = walk(world.stations, count, seed)
        super().__init__(
            f"synthetic-{scene}-{seed}",
            with_walls(world.things, walls, seed),
            poses,
            CAMERA.resized(width, height),
            sensor,
            seed,
            partial(SyntheticScene, scene, seed, n_frames, width, height, **options),
            relations=world.relations,
            frames_per_s=rate,
            misalignment=misalignment,
            light=light,
            walkers=walkers(world.things, poses, rate, people, seed),
            # The shutter stays open as long as at 15 frames/s, however far apart the frames are.
            earlier=walk(world.stations, count, seed, earlier_s=1 / FRAMES_PER_S),
        )


def _world(scene: str, seed: int, extent_m: tuple[float, float] | None) -> World:
    if extent_m is None:
        return SCENES[scene](seed)
    if scene not in SIZED:
        raise BadInput(f"{scene} has a size of its own: an extent is for {' and '.join(SIZED)}")
    make, least = SIZED[scene]
    if not (least[0] <= extent_m[0] <= MOST_M and least[1] <= extent_m[1] <= MOST_M):
        raise BadInput(f"{scene} needs an extent of {least[0]:g}x{least[1]:g} to {MOST_M:g}x{MOST_M:g} metres")
    return make(seed, extent_m)
