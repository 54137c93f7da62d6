"""Work done ahead on one thread, in order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def prefetch(work: Callable[[int], T], indices: Iterable[int], ahead: int = 2) -> Iterator[T]:
    """`work(index)` for each index, in order, at most `ahead` of them done before they are asked for.

    What the work raises is raised here, at that index's turn.
    """
    with ThreadPoolExecutor(1, thread_name_prefix="prefetch") as worker:
        pending: deque[Future[T]] = deque()
        for index in indices:
            pending.append(worker.submit(work, index))
            if len(pending) > ahead:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
