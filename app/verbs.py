"""The verbs of the command line by what they are for, each with a line about it and examples."""

from __future__ import annotations

from typing import NamedTuple


class Verb(NamedTuple):
    """Where a verb's function lies, what it does in a line, and calls to learn from; `is_app` where the target is no
    function but an App, which has further commands and says its examples itself."""

    target: str
    about: str
    examples: tuple[str, ...]
    is_app: bool = False

    @property
    def name(self) -> str:
        """What a user types."""
        return self.target.partition(":")[0].rpartition(".")[2]

    @property
    def epilogue(self) -> str:
        """What stands below its options in the help."""
        return "  \n".join(("Examples:", *self.examples))  # two blanks end a line of Markdown


VERBS = {
    "Map": (
        Verb(
            "map.run:run",
            "Map an RGB-D recording, with given or estimated poses.",
            (
                "razer run FOLDER -o OUT",
                "razer run FOLDER -o OUT --poses slam --stride 2 --view",
                "razer run FOLDER -o OUT --segmenter yolo+semantic --serve",
            ),
        ),
        Verb(
            "map.track:track",
            "Estimate the camera's trajectory by RGB-D SLAM, without a map.",
            ("razer track FOLDER -o trajectory.txt", "razer track FOLDER -o trajectory.txt --frames 500 --json"),
        ),
        Verb(
            "map.batch:verb",
            "Map many recordings: several at once here, or on a cluster.",
            (
                "razer batch run FOLDER -o OUT",
                "razer batch run scans.txt -o OUT --workers 4 --eval scannet200",
                "razer batch run s3://BUCKET/scans -o s3://BUCKET/maps --address auto",
            ),
            is_app=True,
        ),
        Verb("map.demo:demo", "Map a small synthetic room: no data, no models.", ("razer demo", "razer demo -o OUT")),
    ),
    "Ask": (
        Verb(
            "ask.query:query",
            "Find instances by a text or by a picture.",
            (
                'razer query OUT "a red chair"',
                'razer query OUT "something to sit on" --render hits.png',
                "razer query OUT --image mug.jpg --json",
            ),
        ),
        Verb(
            "ask.label:label",
            "Name all instances by a vocabulary.",
            ("razer label OUT --vocabulary lvis", "razer label OUT --vocabulary my_classes.csv"),
        ),
        Verb(
            "ask.library:verb",
            "Keep the instances of many maps in one table, and search them all.",
            (
                "razer library add OUT --library maps.lance",
                'razer library query "a red chair" --library maps.lance',
                "razer library compact --library maps.lance",
            ),
            is_app=True,
        ),
        Verb(
            "ask.edit:edit",
            "Rename, merge, split or delete instances by hand; undo.",
            ('razer edit OUT rename 12 "office chair"', "razer edit OUT merge 12 31", "razer edit OUT undo"),
        ),
    ),
    "Look": (
        Verb(
            "look.view:view",
            "Look at a run: its timeline in Rerun, a picture, a page.",
            (
                "razer view OUT --web",
                "razer view OUT --page map.html",
                "razer view OUT --picture map.png --angle top",
                "razer view GIVEN SLAM",
            ),
        ),
        Verb(
            "look.serve:serve",
            "Serve a map: page in the browser, API for programs.",
            ("razer serve OUT", "razer serve OUT --host 0.0.0.0 --token A-LONG-SECRET-WORD"),
        ),
        Verb(
            "look.mcp:mcp", "Offer a map as tools for agents (MCP).", ("razer mcp OUT", "razer mcp OUT --allow-edits")
        ),
    ),
    "Measure": (
        Verb(
            "measure.eval:evaluate",
            "Evaluate a map against the ground truth.",
            ("razer eval OUT --truth TRUTH", "razer eval OUT --truth SCAN --preset scannet200"),
        ),
        Verb(
            "measure.compare:compare",
            "Compare two runs over one recording.",
            ("razer compare GIVEN SLAM", "razer compare GIVEN SLAM --truth TRUTH -o SHEETS"),
        ),
        Verb(
            "measure.bench:verb",
            "Measure time per stage and memory, beside plain TSDF fusion; or pose estimation in hard worlds.",
            (
                "razer bench",
                "razer bench FOLDER --frames 200 --repeat 3",
                "razer bench poses --worlds blind-1s,fast-turns --seed 1,2",
            ),
            is_app=True,
        ),
        Verb(
            "measure.ablate:ablate",
            "Measure what each part of the method contributes.",
            ("razer ablate --seeds 0,1 --stride 1,6",),
        ),
        Verb(
            "measure.reproduce:reproduce", "Reproduce one of the paper's tables.", ("razer reproduce replica FOLDER",)
        ),
    ),
    "Prepare": (
        Verb("prepare.inspect:inspect", "Check a recording and name what looks wrong.", ("razer inspect FOLDER",)),
        Verb(
            "prepare.convert:convert",
            "Convert a recording to our own or another layout.",
            ("razer convert recording.bag FOLDER",),
        ),
        Verb(
            "prepare.synth:synth",
            "Render a synthetic recording with its ground truth.",
            ("razer synth FOLDER --scene apartment --seed 3 --frames 300",),
        ),
        Verb("prepare.config:config", "Print every setting with its value, range and meaning.", ("razer config",)),
    ),
}
MODEL_VERBS = {
    "list_models": ("list", "Show the models that can be downloaded by name."),
    "info": ("info", "Show a model's source, licence, files, and whether it is in the cache."),
    "pull": ("pull", "Download a model, or resume a broken download."),
}


def named(name: str) -> Verb:
    """The verb that a user types so; raises StopIteration for none."""
    return next(verb for verbs in VERBS.values() for verb in verbs if verb.name == name)
