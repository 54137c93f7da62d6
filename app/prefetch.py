"""Frames read ahead of the method on one thread, in order."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from time import perf_counter

from data_tools.sequence import Sequence
from razer.frame import Frame, UnusableFrame


@dataclass(frozen=True, slots=True)
class Decoded:
    """One frame as read: the frame, or None with the reason; decode_ms is the reading thread's time."""

    index: int
    frame: Frame | None
    reason: str
    decode_ms: float


def prefetch(sequence: Sequence, indices: Iterable[int], ahead: int = 3) -> Iterator[Decoded]:
    """The frames at `indices`, in order, at most `ahead` of them read before they are asked for.

    What reading one frame raises, other than UnusableFrame, is raised here at that frame's turn.
    """
    with ThreadPoolExecutor(1, thread_name_prefix="decode") as reader:
        pending: deque[Future[Decoded]] = deque()
        for index in indices:
            pending.append(reader.submit(_decode, sequence, index))
            if len(pending) > ahead:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()


def _decode(sequence: Sequence, index: int) -> Decoded:
    start = perf_counter()
    try:
        frame, reason = sequence[index], ""
    except UnusableFrame as error:
        frame, reason = None, str(error)
    return Decoded(index, frame, reason, 1e3 * (perf_counter() - start))
