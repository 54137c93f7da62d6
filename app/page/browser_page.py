"""The page of a run in the browser: what `PanopticMap.show` opens, as the entry point of `razer.viewers`."""

from __future__ import annotations

import tempfile
import webbrowser
from pathlib import Path

from app.page.write_page import write_page


def show_run(folder: Path) -> Path:
    """Write the offline page of a run or a saved map into a temporary file and open it in the browser; returns the
    file, which stays."""
    target = Path(tempfile.mkdtemp(prefix="razer-")) / f"{folder.absolute().name}.html"
    write_page(folder, target)
    webbrowser.open(target.as_uri())
    return target
