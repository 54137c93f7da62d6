"""The page that shows recordings in Rerun's web viewer: nothing on it comes from another machine.

Rerun's own page asks for fonts elsewhere, its viewer for news of itself and reports what it is used for; here all of
these get an empty answer. It also writes thousands of debug lines to the console, which is most of the time that it
takes to open.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

VIEWER_JS, VIEWER_WASM = "re_viewer.js", "re_viewer_bg.wasm"

_PAGE = """<!doctype html>
<html>
<head>
<meta charset="utf-8">
<title>TITLE</title>
<link rel="icon" href="data:,">
<style>
html, body { margin: 0; height: 100%; overflow: hidden; background: #fff; font: 16px sans-serif; color: #444; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; }
#note { position: absolute; top: 45%; width: 100%; text-align: center; }
</style>
</head>
<body>
<div id="note">loading the viewer</div>
<canvas id="viewer"></canvas>
<script>
for (const level of ["debug", "trace", "info", "log"]) console[level] = () => {};
const fetchHere = window.fetch.bind(window);
window.fetch = (what, options) => {
  const url = new URL(what.url ?? what, location.href);
  return url.origin === location.origin ? fetchHere(what, options) : Promise.resolve(new Response(null, {status: 204}));
};
</script>
<script src="JS"></script>
<script>
const note = document.getElementById("note");
const fail = (error) => { note.textContent = "The viewer does not start: " + error; console.error(error); };
wasm_bindgen({ module_or_path: fetch("WASM") }).then(async () => {
  const handle = new wasm_bindgen.WebHandle(OPTIONS);
  await handle.start(document.getElementById("viewer"));
  note.remove();
}).catch(fail);
</script>
</body>
</html>
"""


def page(title: str, urls: Sequence[str]) -> str:
    """The HTML of a page that opens the recordings at these addresses, in one viewer."""
    options = {
        "url": list(urls),
        "hide_welcome_screen": True,
        "persist": False,  # a layout kept from an earlier recording would hide that of this one
        "enable_history": False,
        "notebook": False,
        "theme": "light",
    }
    text = _PAGE.replace("JS", VIEWER_JS).replace("WASM", VIEWER_WASM)
    return text.replace("OPTIONS", json.dumps(options)).replace("TITLE", escape(title))
