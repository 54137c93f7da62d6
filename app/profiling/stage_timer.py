"""Wall-clock time of the stages of the work, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from time import perf_counter

from razer.stages import measured_by


@contextmanager
def time_stages(
    earlier_ms: Mapping[str, float] | None = None, wait: Callable[[], None] = lambda: None
) -> Iterator[dict[str, float]]:
    """Milliseconds by stage, on top of `earlier_ms`: within this context every stage adds to them when it ends, after
    `wait` returned, which waits for work that a device has still to do; one within another is part of that."""
    stage_ms = dict(earlier_ms or {})

    @contextmanager
    def measure(name: str) -> Iterator[None]:
        start_s = perf_counter()
        try:
            with measured_by(lambda inner: nullcontext()):
                yield
        finally:
            wait()
            stage_ms[name] = stage_ms.get(name, 0.0) + 1e3 * (perf_counter() - start_s)

    with measured_by(measure):
        yield stage_ms
