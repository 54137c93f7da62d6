"""A library of maps, served until a signal comes."""

from __future__ import annotations

import os

from fastapi import FastAPI

from app.served_map.shared_library import SharedLibrary
from app.server.access_rules import AccessRules
from app.server.bounded_pool import BoundedPool
from app.server.create_app import PREFIX, documented_app
from app.server.guard import Guard
from app.server.routes.library_routes import library_pages, library_routes
from app.server.run_server import Server, address_of, open_socket
from app.server.served import QUERIES_WAITING, QUERY_THREADS
from razer.plugins import Trust


def library_app(library: SharedLibrary, pool: BoundedPool, rules: AccessRules) -> FastAPI:
    """The web application of a library, without who may ask it."""
    app = documented_app("A library of 3D maps: which of their instances a text means.")
    app.include_router(library_routes(library, pool), prefix=PREFIX)
    app.include_router(library_pages(library, pool, rules))
    return app


def serve_library(uri: str, rules: AccessRules, port: int, trust: Trust) -> None:
    """Serve a library; returns after Ctrl-C or SIGTERM. Raises BadInput where it or the place cannot be used."""
    library, pool = SharedLibrary(uri, trust), BoundedPool(QUERY_THREADS, QUERIES_WAITING)
    listener = open_socket(rules.host, port)
    sign_in = "" if rules.token is None else f"?token={rules.token}"
    server = Server(Guard(library_app(library, pool, rules), rules), lambda: None)
    with server.capture_signals():
        print(f"serving {uri} at {address_of(listener)}{sign_in} (Ctrl-C ends it)", flush=True)
        server.run([listener])
    if not pool.is_idle:
        os._exit(0)  # libraries that are at work in a thread do not survive their own orderly end
