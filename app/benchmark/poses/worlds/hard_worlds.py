"""Hard worlds: walks through synthetic scenes, each with something that pose estimation finds difficult."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from app.benchmark.poses.worlds.fast_turns import VIDEO_PER_S, FastTurns
from app.benchmark.poses.worlds.hard_walk import HardWalk, JoinedFrames, dark, shuffled, to_and_fro
from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S, usual_frames
from data_tools.synthetic.synthetic_scene import SCENES, SyntheticScene

SMALL, VGA = (320, 240), (640, 480)
N_FRAMES = 240  # of worlds that are no whole walk, at 15 a second
BLIND_S, LONG_BLIND_S = 1.0, 10.0
KINECT, PLAIN = SensorModel.kinect(), SensorModel.plain()
NOISY = replace(KINECT, axial_noise=2.0, shutter=0.5)  # in the dark the shutter stays open for longer
DARK, DARK_SIGMA = 0.12, 4.0  # share of the light, and grey levels of noise
MISALIGNMENT = RgbdMisalignment(0.94, (3.0, -2.0), (0.025, 0.0, 0.0))  # its shift in pixels of SMALL
N_PEOPLE = 3
STRIDES = (1, 2, 4, 8, 16)
_INTO_ROOM = 8  # frames before a door and after the next one that the camera is blind besides
_BEYOND_DOOR_M = 1.0  # from the middle of the hall, roughly

SPARSE = {
    "sparse-room": ("a room, a picture each half second, shuffled", "room", 8),
    "sparse-room-1s": ("a room, a picture a second, shuffled", "room", 16),
    "sparse-apartment": ("an apartment, a picture a second, shuffled", "apartment", 16),
    "sparse-look-alikes": (
        "a corridor with three places alike, a picture each half second, shuffled",
        "corridor-loop",
        8,
    ),
    "sparse-twin-rooms": ("two rooms furnished alike, a picture each half second, shuffled", "twin-rooms", 8),
}  # what is shown, of which scene, every so many of 15 frames/s
IN_ORDER = {
    "sparse-look-alikes-in-order": ("a corridor with three places alike, a picture a second", "corridor-loop", 16),
    "sparse-twin-rooms-in-order": ("two rooms furnished alike, a picture a second", "twin-rooms", 16),
}  # the same, in the order of taking

Recording = Callable[[int], SyntheticScene]


@dataclass(frozen=True, slots=True)
class HardWorld:
    """What is hard about it, its walk by seed and number of frames, None = as many as it usually has, and whether its
    pictures are matched all at once."""

    about: str
    walk: Callable[[int, int | None], HardWalk]
    is_sparse: bool = False


def recorded(name: str, seed: int, *, size: tuple[int, int] = SMALL, **options: Any) -> SyntheticScene:
    """A scene by its name in SCENES, seen by a Kinect unless the options say otherwise."""
    return SyntheticScene(name, seed, None, *size, **{"sensor": KINECT} | options)


def walk_through(
    recording: Recording, seed: int, n_frames: int | None, *, usual: int | None = N_FRAMES, every: int = 1
) -> HardWalk:
    """The beginning of a walk, or all of it, of which every so many frames are shown."""
    frames = recording(seed)
    return HardWalk(frames, tuple(range(0, len(frames), every)[: n_frames or usual]), FRAMES_PER_S / every)


def _shuffled(scene: str, every: int, seed: int, n_frames: int | None) -> HardWalk:
    """Few pictures of a whole walk, in any order."""
    return shuffled(walk_through(partial(recorded, scene), seed, n_frames, usual=None, every=every), seed)


def _strided(stride: int, seed: int, n_frames: int | None) -> HardWalk:
    """The same way whatever the stride, of a camera that takes 30 frames a second."""
    n_video = 2 * usual_frames(SCENES["room"](seed).stations) - 1
    frames = SyntheticScene("room", seed, n_video, *SMALL, sensor=KINECT)
    shown = range(0, n_video, stride)[: -(-2 * (n_frames or N_FRAMES) // stride)]
    return HardWalk(frames, tuple(shown), VIDEO_PER_S / stride)


def _blinded(walk: HardWalk, stretches: Iterable[range]) -> HardWalk:
    """The same walk with the lens covered while it goes on."""
    covered = {number for stretch in stretches for number in stretch}
    return replace(walk, order=tuple(None if n in covered else index for n, index in enumerate(walk.order)))


def _blind_for_a_second(seed: int, n_frames: int | None) -> HardWalk:
    """Twice on the way."""
    walk = walk_through(partial(recorded, "room"), seed, n_frames)
    long = round(BLIND_S * walk.frames_per_s)
    return _blinded(walk, (range(at, at + long) for at in (len(walk) // 3, 2 * len(walk) // 3)))


def _blind_and_elsewhere(seed: int, n_frames: int | None) -> HardWalk:
    """The first part of the walk, nothing for ten seconds, and then, from far along the walk, back to its beginning."""
    frames = recorded("room", seed)
    whole = min(n_frames or len(frames), len(frames))
    begin, back = range(whole // 4), range(5 * whole // 8, -1, -2)
    nothing = (None,) * round(LONG_BLIND_S * FRAMES_PER_S)
    return HardWalk(frames, (*begin, *nothing, *back), FRAMES_PER_S)


def _re_lit(seed: int, n_frames: int | None) -> HardWalk:
    """The same walk, back when it has become evening."""
    walk = _blind_and_elsewhere(seed, n_frames)
    frames = JoinedFrames(walk.recording, recorded("room", seed, light="evening"))
    blind = walk.order.index(None)
    back = tuple(index if index is None else len(walk.recording) + index for index in walk.order[blind:])
    return replace(walk, recording=frames, order=walk.order[:blind] + back)


def _to_and_fro(seed: int, n_frames: int | None) -> HardWalk:
    """The same way four times."""
    frames = recorded("room", seed)
    return HardWalk(frames, to_and_fro(min(n_frames or N_FRAMES, len(frames))), FRAMES_PER_S)


def _dark(seed: int, n_frames: int | None) -> HardWalk:
    walk = walk_through(partial(recorded, "room", light="evening", sensor=NOISY), seed, n_frames)
    return replace(walk, change=dark(DARK, DARK_SIGMA, seed))


def _no_light(seed: int, n_frames: int | None) -> HardWalk:
    return replace(walk_through(partial(recorded, "room"), seed, n_frames), change=dark(0.0, 0.0, seed))


def _fast_turns(seed: int, n_frames: int | None) -> HardWalk:
    frames = FastTurns(seed, max(n_frames or N_FRAMES, 2), *SMALL, KINECT)
    return HardWalk(frames, tuple(range(len(frames))), VIDEO_PER_S)


def _blind_between_twins(seed: int, n_frames: int | None) -> HardWalk:
    """Through both rooms, blind from before the first one's door until within the second."""
    walk = walk_through(partial(recorded, "twin-rooms"), seed, n_frames, usual=None, every=3)
    y = walk.recording.poses[list(range(0, len(walk.recording), 3))][: len(walk), 1, 3]
    inside = y < y.max() - _BEYOND_DOOR_M
    doors = np.flatnonzero(np.diff(inside.astype(int)))  # into the first, out of it, into the second, out of it
    stretches = [range(doors[1] - _INTO_ROOM, doors[2] + _INTO_ROOM)] if len(doors) > 2 else []
    return _blinded(walk, stretches)


WORLDS: dict[str, HardWorld] = {
    **{f"stride-{n}": HardWorld(f"a room, every {n} of 30 frames/s", partial(_strided, n)) for n in STRIDES},
    "plain-sensor": HardWorld(
        "the same at 15 frames/s, the sensor's noise alone",
        partial(walk_through, partial(recorded, "room", sensor=PLAIN)),
    ),
    "vga": HardWorld("the same at 640x480", partial(walk_through, partial(recorded, "room", size=VGA))),
    "blind-1s": HardWorld("blind for a second, twice", _blind_for_a_second),
    "blind-10s": HardWorld("blind for ten seconds, then elsewhere, and back", _blind_and_elsewhere),
    "re-lit": HardWorld("the same, back in the evening", _re_lit),
    "to-and-fro": HardWorld("four seconds of a walk, to and fro, twice", _to_and_fro),
    "people": HardWorld("people walk through", partial(walk_through, partial(recorded, "room", people=N_PEOPLE))),
    "dark": HardWorld("dim light, noise", _dark),
    "no-light": HardWorld("no light at all: depth alone", _no_light),
    "blank-walls": HardWorld(
        "once round a corridor whose walls are of one colour",
        partial(walk_through, partial(recorded, "corridor-loop", walls="bare"), usual=None, every=3),
    ),
    "fast-turns": HardWorld("turns to and fro by up to 200 degrees/s, rolling shutter", _fast_turns),
    "misregistered": HardWorld(
        "colour by another camera than declared",
        partial(walk_through, partial(recorded, "room", misalignment=MISALIGNMENT)),
    ),
    "look-alikes": HardWorld(
        "once round a corridor with three places alike",
        partial(walk_through, partial(recorded, "corridor-loop"), usual=None, every=3),
    ),
    "twin-rooms": HardWorld(
        "two rooms furnished alike, one after the other",
        partial(walk_through, partial(recorded, "twin-rooms"), usual=None, every=3),
    ),
    "blind-between-twins": HardWorld("the same, blind from one room into the other", _blind_between_twins),
    **{
        name: HardWorld(about, partial(_shuffled, scene, every), is_sparse=True)
        for name, (about, scene, every) in SPARSE.items()
    },
    **{
        name: HardWorld(about, partial(walk_through, partial(recorded, scene), usual=None, every=every), is_sparse=True)
        for name, (about, scene, every) in IN_ORDER.items()
    },
}
