"""The page of a run in the browser: what `PanopticMap.show` opens, as the entry point of `razer.viewers`."""

from __future__ import annotations

import tempfile
import webbrowser
from importlib import import_module
from pathlib import Path

from razer.errors import BadInput


def show_run(folder: Path) -> Path:
    """Write the offline page of a run into a temporary file and open it in the browser; returns the file, which stays.
    Raises BadInput where this build has no page."""
    try:
        page, payload = import_module("app.page.html"), import_module("app.page.payload")
    except ModuleNotFoundError as error:
        raise BadInput("this build of razer has no page: `razer view RUN --picture FILE.png` draws the map") from error
    text: str = page.page_html("inline", payload.page_payload(folder))
    target = Path(tempfile.mkdtemp(prefix="razer-")) / f"{folder.absolute().name}.html"
    target.write_text(text, encoding="utf-8")
    webbrowser.open(target.as_uri())
    return target
