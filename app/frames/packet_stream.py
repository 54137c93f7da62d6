"""The pipeline ahead of the main loop: located in one process, perceived in a second, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import repeat

from app.frames.frame_packet import (
    AfterLastFrame,
    FramePacket,
    Located,
    LocatedPacket,
    NothingRecovered,
    Request,
    SaveState,
    StateSaved,
    Unusable,
)
from app.frames.helper_wait import HelperWait
from app.frames.locator import Locator
from app.frames.perceiver import Perceiver
from app.frames.prefetch_process import NEVER_OVER, prefetch
from app.frames.second_attempt import SecondAttempt
from app.stored_state.pose_checkpoints import PoseCheckpoints
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.sequence import RgbdSequence
from razer.detection.perception import Perception
from slam.poses import Poses

# Locating takes short and long turns (a loop closure), perceiving always much the same.
LOCATED_AHEAD, PERCEIVED_AHEAD = 4, 2


@dataclass(frozen=True)
class StreamCheckpoints:
    """When the locator's state is to be saved, by how many frames were asked for, `n_before` of them before the stream
    began; and where `poses` are saved to."""

    is_due: Callable[[int], bool]
    poses: PoseCheckpoints
    n_before: int = 0


@contextmanager
def packet_stream(
    sequence: RgbdSequence,
    indices: Iterable[int],
    make_poses: Callable[[], Poses],
    perception: Perception,
    color_warp: ColorWarp | None = None,
    checkpoints: StreamCheckpoints | None = None,
    waiting: HelperWait = NEVER_OVER,
    second_attempt: SecondAttempt | None = None,
) -> Iterator[Iterator[FramePacket | StateSaved]]:
    """Within this context: the packets of all frames, PosesFinal, and the frames that came to be known late.

    Args:
        sequence: the recording, which travels to the first process.
        indices: of the frames, ascending.
        make_poses: makes the source of poses, in the first process.
        perception: the 2D models and the lifting, which travel to the second process.
        color_warp: brings colour onto depth once frames are located; None = it lies there.
        checkpoints: when StateSaved is to come between frames, and how; None = never.
        waiting: ends the stream, and says what is waited for.
        second_attempt: estimates poses anew where too many frames are lost in the end.
    """
    of_poses = None if checkpoints is None else checkpoints.poses
    locator = Locator(sequence, make_poses, color_warp, of_poses, second_attempt)
    requests = _requests(indices, checkpoints)
    locating = prefetch(locator, requests, LOCATED_AHEAD, does="reads and locates frames", waiting=waiting)
    located = _until_nothing_recovered(locating)
    perceiving = prefetch(
        Perceiver(perception), located, PERCEIVED_AHEAD,
        does="finds masks", waiting=waiting, replacement=_unperceived,
    )  # fmt: skip
    with closing(locating), closing(perceiving):
        yield perceiving


def _unperceived(packet: LocatedPacket, reason: str) -> FramePacket | StateSaved:
    """What a packet comes to that could not be perceived."""
    if not isinstance(packet, Located):
        return packet
    update, stage_ms = packet.pose_update, packet.stage_ms
    return Unusable(packet.index, reason, pose_update=update, stage_ms=stage_ms, is_late=packet.is_late)


def _requests(indices: Iterable[int], checkpoints: StreamCheckpoints | None) -> Iterator[Request]:
    n_before = 0 if checkpoints is None else checkpoints.n_before
    for n_frames, index in enumerate(indices, start=n_before + 1):
        yield index
        if checkpoints is not None and checkpoints.is_due(n_frames):
            yield SaveState(n_frames)
    yield AfterLastFrame.FINISH_POSES
    yield from repeat(AfterLastFrame.NEXT_RECOVERED)  # asked ahead, and so more often than there are such frames


def _until_nothing_recovered(answers: Iterable[LocatedPacket | NothingRecovered]) -> Iterator[LocatedPacket]:
    for answer in answers:
        if isinstance(answer, NothingRecovered):
            return
        yield answer
