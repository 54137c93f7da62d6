"""What the routes answer from: the map, the threads, the streams of events."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from app.served_map.asked_map import AskedMap
from app.served_map.edit_models import EditDone, EditList, EditStamp
from app.server.bounded_pool import BoundedPool
from app.server.event_streams import EventStreams

QUERY_THREADS, QUERIES_WAITING = 2, 128
SLOW_THREADS, SLOW_WAITING = 1, 32


class MapSource(Protocol):
    """Where the map comes from: a finished run, or one that goes on."""

    @property
    def current(self) -> AskedMap:
        """The map as it is now."""
        ...

    def tend(self) -> None:
        """Do what is left to do, now and then: follow changes of files, and let others follow edits."""
        ...

    def page(self) -> bytes:
        """The data that the page shows."""
        ...

    def changes(self, since: int) -> bytes:
        """What of the mesh changed after a revision; raises NoSuchInstance where it does not grow."""
        ...

    @property
    def edits(self) -> EditList:
        """The edit log."""
        ...

    def edit(self, request: EditStamp) -> EditDone:
        """Make an edit; raises EditConflict, BadInput."""
        ...

    def undo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Take back the last edit; raises EditConflict."""
        ...

    def redo(self, author: str = "", epoch: int | None = None) -> EditDone:
        """Do again what was undone last; raises EditConflict."""
        ...


@dataclass
class Served:
    """One map and all that is shared by those who ask it: `pool` for what is answered at once, `slow` for what takes
    seconds the first time, such as the page."""

    source: MapSource
    events: EventStreams = field(default_factory=EventStreams)
    pool: BoundedPool = field(default_factory=lambda: BoundedPool(QUERY_THREADS, QUERIES_WAITING))
    slow: BoundedPool = field(default_factory=lambda: BoundedPool(SLOW_THREADS, SLOW_WAITING))
