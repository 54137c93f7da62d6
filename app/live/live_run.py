"""A run that is served while it goes on: its side of the process that serves."""

from __future__ import annotations

from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

from app.live.live_process import serve_live
from app.live.live_timeline import LiveTimeline
from app.live.publisher import Publisher
from app.live.snapshot import Finished
from app.server.access_rules import AccessRules
from app.server.run_server import address_of, open_socket
from app.settings.run_config import RunConfig
from app.timeline.null_timeline import NullTimeline

if TYPE_CHECKING:
    from app.timeline.rerun_timeline import Timeline

_STOP_S = 5.0


class LiveRun:
    """Serves one run, from its start until Ctrl-C after its end; as a context it leaves nothing behind."""

    def __init__(self, rules: AccessRules, port: int) -> None:
        """Take the port; raises BadInput where it cannot be had."""
        self._rules, self._listener = rules, open_socket(rules.host, port)
        self.address = address_of(self._listener)
        self._publisher: Publisher | None = None

    def start(self, folder: Path, config: RunConfig) -> None:
        """Begin to serve a run whose unfinished folder exists by now."""
        context = get_context("spawn")
        theirs, ours = context.Pipe(duplex=False)
        arguments = (theirs, self._listener, self._rules, folder, config)
        self._process = context.Process(target=serve_live, args=arguments, name="serve", daemon=True)
        self._process.start()
        theirs.close()
        self._listener.close()
        self._publisher = Publisher(ours)

    def timeline(self, timeline: Timeline | NullTimeline) -> LiveTimeline:
        """A timeline that is served, too."""
        assert self._publisher is not None
        return LiveTimeline(timeline, self._publisher)

    def finish(self, folder: Path) -> None:
        """Serve the finished run from now on."""
        assert self._publisher is not None
        self._publisher.finish(Finished(folder))

    @property
    def is_alive(self) -> bool:
        """Whether it still serves."""
        return self._publisher is not None and self._process.is_alive()

    def wait(self) -> None:
        """Go on serving until Ctrl-C."""
        with suppress(KeyboardInterrupt):
            self._process.join()

    def __enter__(self) -> LiveRun:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()
        if self._publisher is not None:
            self._process.terminate()
            self._process.join(_STOP_S)
            self._process.kill()
