"""HTTP server of Rerun's web viewer and of the recordings of a run: a process of its own.

It only reads files, so that the run that writes them waits for no browser, however slow.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from functools import cached_property
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from app.timeline.recording.live_files import growing, live_parts, recordings_at
from app.timeline.recording.web_assets import web_assets
from app.timeline.viewer.free_port import HOST, free_port
from app.timeline.viewer.page import VIEWER_JS, VIEWER_WASM, page
from app.timeline.viewer.rerun_viewer import UNTIL_IDLE, WINDOW, window_command

LINGER_S = 60.0  # after the run, for a browser that comes late
CHECK_S = 2.0
_LOCAL = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?", re.IGNORECASE)
_TYPES = {VIEWER_JS: "text/javascript", VIEWER_WASM: "application/wasm"}


class PageServer(ThreadingHTTPServer):
    """Serves `/`, the two files of the viewer, and `/N.rrd`, the N-th recording of `run`, as far as it is written and
    on as it grows."""

    daemon_threads = True

    def __init__(self, run: Path, port: int) -> None:
        super().__init__((HOST, port), _Handler)
        self.run = run
        self.last_use_s = time.monotonic()

    @cached_property
    def assets(self) -> dict[str, bytes]:
        """The viewer's files."""
        return web_assets(list(_TYPES), free_port(0))

    def end_when_idle(self) -> None:
        """Stop serving a while after the run has ended and the last browser has what it asked for."""
        while live_parts(self.run) or time.monotonic() - self.last_use_s < LINGER_S:
            time.sleep(CHECK_S)
        self.shutdown()

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that goes away is no error."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Handler(BaseHTTPRequestHandler):
    server: PageServer

    def do_GET(self) -> None:
        """Answer one request."""
        self.server.last_use_s = time.monotonic()
        host = self.headers.get("Host", HOST)
        if not _LOCAL.fullmatch(host):  # a page elsewhere may give this machine a name of its own
            return self.send_error(421, "this server is not called that")
        name = self.path.partition("?")[0].lstrip("/")
        if name in _TYPES:
            return self._send(self.server.assets[name], _TYPES[name], "max-age=86400")
        recordings = {f"{number}.rrd": path for number, path in enumerate(recordings_at(self.server.run))}
        if name in recordings:
            return self._stream(recordings[name])
        if name == "":
            urls = [f"http://{host}/{recording}" for recording in recordings]
            return self._send(page(self.server.run.name, urls).encode(), "text/html; charset=utf-8", "no-store")
        return self.send_error(404)

    def _send(self, content: bytes, kind: str, caching: str) -> None:
        self._start(kind, caching)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _stream(self, path: Path) -> None:
        with path.open("rb") as file:
            self._start("application/octet-stream", "no-store")
            self.end_headers()
            for part in growing(file):
                self.wfile.write(part)
                self.server.last_use_s = time.monotonic()

    def _start(self, kind: str, caching: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", caching)

    def log_message(self, *_: object) -> None:
        """Requests are nobody's business."""


def serve(run: Path, port: int, *, until_idle: bool, window: bool) -> None:
    """Serve until the process ends, or with `until_idle` until nobody needs it any more; with `window` Rerun's own is
    opened on what is served."""
    with PageServer(run, port) as server:
        if until_idle:
            threading.Thread(target=server.end_when_idle, daemon=True).start()
        if window:
            urls = [f"http://{HOST}:{port}/{number}.rrd" for number in range(len(recordings_at(run)))]
            subprocess.Popen(window_command(urls))
        server.serve_forever(poll_interval=0.2)


if __name__ == "__main__":
    serve(Path(sys.argv[1]), int(sys.argv[2]), until_idle=UNTIL_IDLE in sys.argv[3:], window=WINDOW in sys.argv[3:])
