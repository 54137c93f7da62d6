"""Who sees a run while it goes on: browsers, Rerun's viewer, or nobody."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from app.live.live_run import LiveRun
    from app.timeline.viewer.live_viewer import ViewerKind


@dataclass(frozen=True)
class Watchers:
    """live: what shows the map to browsers; viewer: the kind of Rerun's viewer that shows the timeline as it is
    written; None = nothing."""

    live: LiveRun | None = None
    viewer: ViewerKind | None = None


NOBODY = Watchers()
