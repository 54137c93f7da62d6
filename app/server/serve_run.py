"""A finished run, served until a signal comes."""

from __future__ import annotations

import gc
import os
import threading
from pathlib import Path

from app.page.other_poses import chosen_run
from app.served_map.edit_models import told
from app.served_map.shared_map import SharedMap
from app.server.access_rules import AccessRules
from app.server.create_app import guarded
from app.server.run_server import Server, address_of, open_socket
from app.server.served import Served
from razer.plugins import Trust


def serve_run(run: Path, rules: AccessRules, port: int, trust: Trust) -> None:
    """Serve a run's map; returns after Ctrl-C or SIGTERM. Raises BadInput where the map or the place cannot be used."""
    shared = SharedMap(chosen_run(run), trust=trust)
    served = Served(shared)
    shared.on_change(lambda last, epoch: served.events.announce("edit", told(last, epoch)))
    listener = open_socket(rules.host, port)
    warming = threading.Thread(target=_warm_up, args=(shared,), daemon=True)
    warming.start()
    sign_in = "" if rules.token is None else f"?token={rules.token}"
    server = Server(guarded(served, rules), served.events.close)
    with server.capture_signals():  # from when people know of it
        print(f"serving {run} at {address_of(listener)}{sign_in} (Ctrl-C ends it)", flush=True)
        server.run([listener])
    shared.renew_files()
    if warming.is_alive() or not served.pool.is_idle:
        os._exit(0)  # libraries that are at work in a thread do not survive their own orderly end


def _warm_up(shared: SharedMap) -> None:
    """Work out what the first question would wait for."""
    current = shared.current
    _ = current.instances, current.relations, shared.page()
    gc.collect()
    gc.freeze()  # collecting garbage among all that is loaded would hold up every answer for 0.15 s
