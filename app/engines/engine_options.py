"""Command-line options of verbs whose work runs on an engine."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from app.settings.extra_libraries import require_cluster
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.engines.engine import Engine

PLACING = Group("Placing", sort_key=0)


@Parameter(name="*")
@dataclass(frozen=True)
class EngineOptions:
    """Where work is done, and how much at once."""

    workers: Annotated[int | None, Parameter(group=PLACING, show_default=False)] = None
    """At most so many at once; memory bounds them in any case. Not given: as many as the cores allow."""
    address: Annotated[str | None, Parameter(group=PLACING, show_default=False)] = None
    """Run on a Ray cluster: auto, the one that this machine is part of, or ray://HOST:10001."""

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise BadInput(f"--workers {self.workers}: give at least 1")

    def engine(self) -> Engine:
        """What runs the work; raises BadInput where that cannot be had."""
        if self.address is None:
            from app.engines.local_engine import LocalEngine

            return LocalEngine(self.workers)
        require_cluster()
        from app.engines.ray_engine import RayEngine

        return RayEngine(self.address, self.workers)


@Parameter(name="*")
@dataclass(frozen=True)
class PlacingOptions(EngineOptions):
    """And what each scene is given."""

    cores: Annotated[int, Parameter(group=PLACING, show_default=False)] = 0
    """Hold each scene to so many cores of its machine. Not given: the system divides them."""
    gpus: Annotated[float | None, Parameter(group=PLACING, show_default=False)] = None
    """GPUs that a scene asks for, such as 0.5. Not given: 1 with --device cuda, else none."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for option, number in (("--cores", self.cores), ("--gpus", self.gpus or 0.0)):
            if not 0 <= number < inf:
                raise BadInput(f"{option} {number}: give 0 or more")
