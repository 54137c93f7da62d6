"""The pipeline ahead of the main loop: located in one process, perceived in a second, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from itertools import repeat

from app.frames.frame_packet import AfterLastFrame, FramePacket, LocatedPacket, NothingRecovered, Request
from app.frames.locator import Locator
from app.frames.perceiver import Perceiver
from app.frames.prefetch_process import prefetch
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.sequence import RgbdSequence
from razer.detection.perception import Perception
from slam.poses import Poses

# Locating takes short and long turns (a loop closure), perceiving always much the same.
LOCATED_AHEAD, PERCEIVED_AHEAD = 4, 2


@contextmanager
def packet_stream(
    sequence: RgbdSequence,
    indices: Iterable[int],
    make_poses: Callable[[], Poses],
    perception: Perception,
    color_warp: ColorWarp | None = None,
) -> Iterator[Iterator[FramePacket]]:
    """Within this context: the packets of all frames, PosesFinal, and the frames that came to be known late.

    Args:
        sequence: the recording, which travels to the first process.
        indices: of the frames, ascending.
        make_poses: makes the source of poses, in the first process.
        perception: the 2D models and the lifting, which travel to the second process.
        color_warp: brings colour onto depth once frames are located; None = it lies there.
    """
    locating = prefetch(Locator(sequence, make_poses, color_warp), _requests(indices), depth=LOCATED_AHEAD)
    perceiving = prefetch(Perceiver(perception), _until_nothing_recovered(locating), depth=PERCEIVED_AHEAD)
    with closing(locating), closing(perceiving):
        yield perceiving


def _requests(indices: Iterable[int]) -> Iterator[Request]:
    yield from indices
    yield AfterLastFrame.FINISH_POSES
    yield from repeat(AfterLastFrame.NEXT_RECOVERED)  # asked ahead, and so more often than there are such frames


def _until_nothing_recovered(answers: Iterable[LocatedPacket | NothingRecovered]) -> Iterator[LocatedPacket]:
    for answer in answers:
        if isinstance(answer, NothingRecovered):
            return
        yield answer
