"""The command line. Verbs are imported when they are used, so that `razer --help` is instant."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import metadata

from cyclopts import App, CycloptsError

BAD_INPUT = 2

app = App(
    name="razer",
    help="RGB-D recordings become 3D panoptic maps that know what is where.",
    help_format="plaintext",
    version=lambda: metadata.version("razer"),
)
app.command("app.run:run", name="run", help="Map a posed RGB-D recording.")
app.command("app.track:track", name="track", help="Estimate the camera's path, without a map.")
app.command("app.view:view", name="view", help="Open the timeline of a run in Rerun.")
app.command("app.query:query", name="query", help="Find instances of a map by words or by a picture.")
app.command("app.label:label", name="label", help="Give the instances of a map classes of a vocabulary.")
app.command("app.show_config:config", name="config", help="Print every setting with its value, range and meaning.")
app.command("app.inspect_recording:inspect", name="inspect", help="Say what a recording is and what looks wrong.")
app.command("app.convert:convert", name="convert", help="Write a recording anew, in our own or another layout.")
app.command("app.synth:synth", name="synth", help="Write a recording of a simulated place with its truth.")
app.command("app.evaluate:evaluate", name="eval", help="Measure a map against the truth.")
app.command("app.compare:compare", name="compare", help="Compare two runs over one recording.")
app.command("app.reproduce:reproduce", name="reproduce", help="Map and evaluate a table of the paper.")
app.command("app.ablate:ablate", name="ablate", help="Measure what each part of the method contributes.")
app.command("app.bench:bench", name="bench", help="Measure time per stage and memory, beside plain TSDF fusion.")
app.command("app.demo:demo", name="demo", help="Map a small synthetic room, no data needed.")

models = App(name="models", help="List and fetch 2D models.", help_format="plaintext")
models.command("app.models:list_models", name="list", help="Show the models that can be fetched by name.")
models.command("app.models:info", name="info", help="Show a model's source, licence, files, and whether it is here.")
models.command("app.models:pull", name="pull", help="Fetch a model, or go on where a download broke off.")
app.command(models)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit: 0 done, 2 unusable input or usage (one plain line), 130 interrupted."""
    try:
        code = app(arguments, exit_on_error=False, result_action="return_value")
    except CycloptsError:
        sys.exit(BAD_INPUT)
    except ValueError as error:
        from razer.frame import BadInput  # late: it brings numpy along

        if not isinstance(error, BadInput):
            raise
        print(f"razer: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    sys.exit(code)


if __name__ == "__main__":
    main()
