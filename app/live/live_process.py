"""The process that serves a running run: it may be slow, and it may die, and the run goes on."""

from __future__ import annotations

import os
import pickle
import signal
import socket
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

from app.console.plain_warnings import warn_in_one_line
from app.live.live_map import LiveMap
from app.live.snapshot import Finished
from app.served_map.edit_models import told
from app.server.access_rules import AccessRules
from app.server.create_app import guarded
from app.server.event_streams import EventStreams
from app.server.run_server import Server
from app.server.served import Served
from app.settings.run_config import RunConfig
from razer.errors import BadInput

NICENESS = 10  # what people look at waits for what is mapped


def serve_live(pipe: Connection, listener: socket.socket, rules: AccessRules, folder: Path, config: RunConfig) -> None:
    """Serve what comes down a pipe until the run that sends it is gone, or ends this with SIGTERM.

    Args:
        pipe: pickled snapshots, then that the run is finished.
        listener: where to serve.
        rules: who may ask.
        folder: the unfinished one of the run.
        config: the run's settings.
    """
    warn_in_one_line()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group, and is the run's to handle
    os.nice(NICENESS)
    events = EventStreams()
    live = LiveMap(folder, config, events.announce)
    served = Served(live, events)
    server = Server(guarded(served, rules), events.close, signals=(signal.SIGTERM,))
    threading.Thread(target=_follow, args=(pipe, live, served, server, config), daemon=True).start()
    server.run([listener])


def _follow(pipe: Connection, live: LiveMap, served: Served, server: Server, config: RunConfig) -> None:
    with suppress(EOFError, OSError):
        while True:
            message = pickle.loads(pipe.recv_bytes())
            if isinstance(message, Finished):
                with suppress(BadInput):
                    finished = live.finish(message.folder, config.embedder.trust)
                    finished.on_change(lambda last, epoch: served.events.announce("edit", told(last, epoch)))
            else:
                live.take(message)
    server.should_exit = True
