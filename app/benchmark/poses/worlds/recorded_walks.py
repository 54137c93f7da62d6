"""Recorded walks: a recording with poses, shown backwards, with the lens covered, cut, or as few pictures in any order.

Rendered worlds have one exposure. What an automatic camera does between two views of one place is in recordings alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.benchmark.poses.worlds.hard_walk import HardWalk, dark, shuffled, to_and_fro
from app.benchmark.poses.worlds.hard_worlds import HardWorld
from app.frames.open_recording import require_poses
from data_tools.recordings.sequence import RgbdSequence, usable_frames
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics

LEAST_FRAMES = 30
BLIND_S, GAPS = 2.0, (0.2, 0.45, 0.7)  # how long the lens is covered, and at which shares of the way
BLINK, BLINK_EVERY = 3, 60  # frames
LEAST_PIECES = 6  # of a short recording
SPARSE_STRIDES = (8, 16)
JITTER = 0.05  # share of the way by which seeds shift the gaps

Order = tuple[int | None, ...]


@dataclass(frozen=True)
class PosedRecording:
    """The frames of a recording that have poses (N, 4, 4), by their number among these."""

    sequence: RgbdSequence
    indices: tuple[int, ...]
    poses: Float64Array
    frames_per_s: float

    @classmethod
    def of(cls, sequence: RgbdSequence) -> PosedRecording:
        """All that can be used; raises BadInput where it is too little."""
        require_poses(sequence)
        posed = [(f.index, f.stamp, f.pose) for f in _usable(sequence) if f.world_from_camera is not None]
        if len(posed) < LEAST_FRAMES:
            raise BadInput(f"{sequence.name}: {len(posed)} frames with poses, {LEAST_FRAMES} are needed")
        indices, stamps, poses = zip(*posed, strict=True)
        return cls(sequence, indices, np.stack(poses), 1 / max(float(np.median(np.diff(stamps))), 1e-3))

    @property
    def intrinsics(self) -> Intrinsics:
        """Those of the recording."""
        return self.sequence.intrinsics

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, number: int) -> Frame:
        return self.sequence[self.indices[number]]


def _usable(sequence: RgbdSequence) -> Iterator[Frame]:
    return usable_frames(sequence, lambda *_: None)


def _gaps(n: int, long: int, seed: int) -> list[range]:
    """Stretches of the way, each of so many frames."""
    shift = np.random.default_rng([seed, 107]).uniform(-JITTER, JITTER, len(GAPS))
    return [range(int(at * n), min(int(at * n) + long, n)) for at in np.array(GAPS) + shift]


def _blinded(n: int, long: int, seed: int) -> Order:
    dark = {index for gap in _gaps(n, long, seed) for index in gap}
    return tuple(None if index in dark else index for index in range(n))


def _blinking(n: int, _: int, seed: int) -> Order:
    """From half of the first interval on, as a recording begins with something."""
    first = BLINK_EVERY // 2 + seed % (BLINK_EVERY // 2)
    return tuple(None if index >= first and (index - first) % BLINK_EVERY < BLINK else index for index in range(n))


def _cut(n: int, long: int, seed: int) -> Order:
    return tuple(index for index in _blinded(n, long, seed) if index is not None)


def _backwards_cut(n: int, long: int, seed: int) -> Order:
    return _cut(n, long, seed)[::-1]


def _jumping(n: int, _: int, seed: int) -> Order:
    """A quarter, then what comes after two thirds, then what lies between."""
    first, second = n // 4 + seed % 10, 2 * n // 3
    return (*range(first), *range(second, n), *range(first, second))


def _shuffled(n: int, long: int, seed: int) -> Order:
    piece = max(1, min(long, n // LEAST_PIECES))
    starts = np.random.default_rng([seed, 109]).permutation(range(0, n, piece)).tolist()
    return tuple(index for start in starts for index in range(start, min(start + piece, n)))


_ORDERS: dict[str, tuple[str, Callable[[int, int, int], Order]]] = {
    "recorded": ("as it was recorded", lambda n, *_: tuple(range(n))),
    "backwards": ("from its end", lambda n, *_: tuple(range(n - 1, -1, -1))),
    "to-and-fro": ("its first quarter, there and back, twice", lambda n, *_: to_and_fro(n)),
    "blinded": ("blind for two seconds, thrice", _blinded),
    "blinking": ("blind for three frames of every sixty", _blinking),
    "cut": ("without these two seconds", _cut),
    "backwards-cut": ("from its end, without these two seconds", _backwards_cut),
    "jumping": ("a quarter, then the end, then what lies between", _jumping),
    "shuffled": ("in pieces of two seconds, in any order", _shuffled),
}
"""What is shown, and the order of its n frames by n, the frames of two seconds, and the seed."""


def recorded_worlds(recording: PosedRecording) -> dict[str, HardWorld]:
    """The walks through a recording by name, of its first frames where they are bounded."""
    shown = {name: HardWorld(about, partial(_walk, recording, order)) for name, (about, order) in _ORDERS.items()}
    shown["no-light"] = HardWorld("as it was recorded, with black images: depth alone", partial(_no_light, recording))
    for stride in SPARSE_STRIDES:
        few = partial(_pictures, recording, stride)
        shown[f"sparse-{stride}-in-order"] = HardWorld(f"every {stride}th frame, as recorded", few, is_sparse=True)
        in_any_order = partial(_shuffled_pictures, recording, stride)
        shown[f"sparse-{stride}"] = HardWorld(f"every {stride}th frame, in any order", in_any_order, is_sparse=True)
    return shown


def _no_light(recording: PosedRecording, seed: int, n_frames: int | None) -> HardWalk:
    return replace(_walk(recording, _ORDERS["recorded"][1], seed, n_frames), change=dark(0.0, 0.0, seed))


def _pictures(recording: PosedRecording, stride: int, seed: int, n_frames: int | None) -> HardWalk:
    """Every so many frames, in the order of taking; seeds begin with another one."""
    shown = range(seed % stride, min(n_frames or len(recording), len(recording)), stride)
    return HardWalk(recording, tuple(shown), recording.frames_per_s / stride)


def _shuffled_pictures(recording: PosedRecording, stride: int, seed: int, n_frames: int | None) -> HardWalk:
    """Every so many frames from the first one, in any order."""
    return shuffled(_pictures(recording, stride, 0, n_frames), seed)


def _walk(
    recording: PosedRecording, order: Callable[[int, int, int], Order], seed: int, n_frames: int | None
) -> HardWalk:
    n = min(n_frames or len(recording), len(recording))
    long = max(1, round(BLIND_S * recording.frames_per_s))
    return HardWalk(recording, order(n, long, seed), recording.frames_per_s)
