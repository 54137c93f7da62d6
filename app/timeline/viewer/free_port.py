"""Free ports of this machine for the viewer's servers."""

from __future__ import annotations

import socket

from razer.errors import BadInput

HOST = "127.0.0.1"  # nobody else's business
PAGE_PORT = 9090


def free_port(preferred: int) -> int:
    """The preferred port, or any other if it is taken; raises BadInput if there is none."""
    for port in (preferred, 0):
        with socket.socket() as probe:
            try:
                probe.bind((HOST, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise BadInput(f"no free port on {HOST}: end a program that listens there")
