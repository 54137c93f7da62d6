"""The command line; verbs are imported when they are used, so that `razer --help` is instant."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import metadata

from cyclopts import App, CycloptsError

from app.console.plain_warnings import warn_in_one_line
from razer.errors import BadInput

BAD_INPUT = 2

app = App(
    name="razer",
    help="RGB-D recordings become 3D panoptic maps that know what is where.",
    help_format="plaintext",
    version=lambda: metadata.version("razer"),
)
VERBS = {
    "Map": {
        "map.run:run": "Map an RGB-D recording, with given or estimated poses.",
        "map.track:track": "Estimate the camera trajectory by RGB-D SLAM, without a map.",
        "map.demo:demo": "Map a small synthetic room, no data needed.",
    },
    "Ask": {
        "ask.query:query": "Find instances of a map by text or by image.",
        "ask.label:label": "Classify the instances of a map by a vocabulary.",
        "ask.edit:edit": "Rename, merge, split or delete instances by hand; undo.",
    },
    "Look": {
        "look.view:view": "Open the timeline of a run in the Rerun viewer.",
        "look.serve:serve": "Serve a map: page in the browser, API for programs.",
        "look.mcp:mcp": "Offer a map as tools for agents (MCP).",
        "look.inspect:inspect": "Check a recording and name what looks wrong.",
        "look.config:config": "Print every setting with its value, range and meaning.",
    },
    "Measure": {
        "measure.eval:evaluate": "Evaluate a map against the ground truth.",
        "measure.compare:compare": "Compare two runs over one recording.",
        "measure.reproduce:reproduce": "Reproduce one of the paper's tables.",
        "measure.ablate:ablate": "Measure what each part of the method contributes.",
        "measure.bench:bench": "Measure time per stage and memory, beside plain TSDF fusion.",
    },
    "Prepare": {
        "prepare.convert:convert": "Convert a recording to our own or another layout.",
        "prepare.synth:synth": "Render a synthetic recording with its ground truth.",
    },
}
MODEL_VERBS = {
    "list_models": ("list", "Show the models that can be downloaded by name."),
    "info": ("info", "Show a model's source, licence, files, and whether it is in the cache."),
    "pull": ("pull", "Download a model, or resume a broken download."),
}


def _add_verbs(app: App) -> None:
    for group, verbs in VERBS.items():
        for target, about in verbs.items():
            name = target.partition(":")[0].rpartition(".")[2]
            app.command(f"app.commands.{target}", name=name, help=about, group=group)
    models = App(name="models", help="List and download 2D models.", help_format="plaintext", group="Prepare")
    for function, (name, about) in MODEL_VERBS.items():
        models.command(f"app.commands.prepare.models:{function}", name=name, help=about)
    app.command(models)


_add_verbs(app)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit: 0 done, 2 unusable input or usage (one plain line), 130 interrupted."""
    # What lies in the working directory is data: helper processes must not import it as modules.
    os.environ["PYTHONSAFEPATH"] = "1"
    warn_in_one_line()
    try:
        code = app(arguments, exit_on_error=False, result_action="return_value")
    except CycloptsError:
        sys.exit(BAD_INPUT)
    except BadInput as error:
        print(f"razer: {_plain(str(error))}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    sys.exit(code)


def _plain(message: str) -> str:
    """A message on one line, without characters that a terminal obeys: names from files are part of it."""
    return "".join(c if c.isprintable() else " " for c in message)


if __name__ == "__main__":
    main()
