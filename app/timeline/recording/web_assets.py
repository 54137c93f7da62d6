"""The files of Rerun's web viewer, as the installed Rerun brings them."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.request import urlopen

import rerun as rr


def web_assets(names: Sequence[str], port: int) -> dict[str, bytes]:
    """Files of the viewer by name, as Rerun's own server gives them at a free port of this machine."""
    rr.start_web_viewer_server(port)
    assets: dict[str, bytes] = {}
    for name in names:
        with urlopen(f"http://127.0.0.1:{port}/{name}") as answer:
            assets[name] = answer.read()
    return assets
