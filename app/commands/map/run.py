"""`razer run`: a recording becomes a panoptic map."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import print_notes, progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import looking_at, serving, viewing
from app.pipeline.watchers import NOBODY, Watchers
from app.profiling.cores import leave_cores_to_helpers
from app.run_folder.run_folder import CONFIG, TIMELINE, RunFolder
from app.settings.config_file import read_run_config
from app.settings.extra_libraries import require_serve
from app.settings.options import BOTH, DEFAULT_PORT, MODELS, WATCHING, Flag, RunOptions
from app.timeline.viewer.live_viewer import ViewerKind, require_viewer
from razer.errors import BadInput
from razer.vocabulary import vocabulary as read_vocabulary

if TYPE_CHECKING:
    from app.live.live_run import LiveRun
    from app.pipeline.run_pipeline import RunResult
    from app.settings.run_config import RunConfig
    from razer.plugins import Trust

View = Annotated[
    tuple[ViewerKind, ...] | None, Parameter(consume_multiple=(0, 1), negative="", show_default=False, group=WATCHING)
]


def run(
    folder: Path | None = None,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], show_default=False)] = None,
    resume: Annotated[Path | None, Parameter(show_default=False)] = None,
    options: RunOptions = RunOptions(),  # noqa: B008
    vocabulary: Annotated[str | None, Parameter(group=MODELS)] = None,
    view: View = None,
    serve: Annotated[Flag, Parameter(group=WATCHING)] = False,
    port: Annotated[int, Parameter(group=WATCHING)] = DEFAULT_PORT,
    overwrite: Flag = False,
    json: Flag = False,
) -> int:
    """Map an RGB-D recording: its surface, the things in it, and where they are.

    Ctrl-C finishes the folder with what was mapped until then (exit code 130). A killed run goes on with --resume.

    Parameters
    ----------
    folder:
        The recording; its layout is recognised.
    out:
        The folder to write; it appears when it is complete. With --poses both it holds given, slam and compare.
    resume:
        Go on with a run to this folder that was cut off, from its newest checkpoint, with the settings that it had.
    vocabulary:
        Name the instances by a vocabulary, as `razer label` does: one of its names, or a file.
    view:
        Watch the run in Rerun's viewer as it goes on; --view web in a browser. The run waits for neither.
    serve:
        Show the map in browsers on this machine while it grows, and when it is finished until Ctrl-C.
    port:
        Where to, with --serve; 0: any free port.
    overwrite:
        Replace an older run at the same place, once the new one is complete.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    if resume is not None:
        given = {"FOLDER": folder, "--out": out, "--vocabulary": vocabulary, "--overwrite": overwrite or None}
        return _resume(resume, given, options, view, port if serve else None, json)
    folder, out = _required(folder, out)
    viewer = None if view is None else checked_viewer(view, replace(options, poses=None).read())
    if options.poses == "both" and serve:
        raise BadInput("--serve shows one run: give --poses given or slam")
    if options.poses == "both":
        return _run_both(folder, out, options, vocabulary, overwrite, json, viewer)
    target = RunFolder(out, overwrite=overwrite)
    return _run_one(folder, options.read(), target, vocabulary, viewer, port if serve else None, json)


def _required(folder: Path | None, out: Path | None) -> tuple[Path, Path]:
    if folder is None or out is None:
        raise BadInput(f"{'FOLDER' if folder is None else '--out'} needs a value. (see razer run --help)")
    return folder, out


def _resume(
    out: Path, given: Mapping[str, object], options: RunOptions, view: View, port: int | None, as_json: bool
) -> int:
    """Go on with a run that was cut off, with the settings that its unfinished folder keeps."""
    set_again = [name for name, value in given.items() if value is not None]
    if set_again or replace(options, trust_plugins=False) != RunOptions():
        what = " and ".join(set_again) or "them"
        raise BadInput(f"--resume goes on with the recording and the settings that the run had: leave {what} out")
    target = RunFolder.unfinished(out)
    assert target.checkpoint is not None
    config = read_run_config(target.partial / CONFIG, trust=options.trust)
    viewer = None if view is None else checked_viewer(view, config)
    if config.input.folder is None:
        raise BadInput(f"{target.partial / CONFIG} does not say which recording the run is of: start it anew")
    recording = Path(config.input.folder)
    return _run_one(recording, config, target, target.checkpoint.vocabulary, viewer, port, as_json)


def _run_one(
    folder: Path,
    config: RunConfig,
    target: RunFolder,
    vocabulary: str | None,
    viewer: ViewerKind | None,
    port: int | None,
    as_json: bool,
) -> int:
    """Run, report, and go on serving where that is asked for; returns the exit code."""
    with _served(port) as live:
        result = _run(folder, config, target, vocabulary, Watchers(live, viewer))
        _report(result, target.final, live, as_json=as_json)
    return result.exit_code


def _report(result: RunResult, folder: Path, live: LiveRun | None, *, as_json: bool) -> None:
    """Say what there is now, and go on showing it where it is served."""
    from app.pipeline.run_report import print_run

    print_run(result, folder, as_json=as_json)
    if not as_json:
        queries = result.panoptic.text_queries
        question = [("query", folder, "a chair")] if queries is not None and queries.knows_words else []
        print_next(looking_at(folder), *question, *serving(folder))
    if live is not None and not result.exit_code:
        _go_on_serving(live)


def checked_viewer(view: tuple[ViewerKind, ...], config: RunConfig) -> ViewerKind:
    """The viewer that --view asks for, the native one where it names none; raises BadInput if it cannot be had, or if
    there is to be no timeline."""
    if not config.run.timeline:
        raise BadInput("--view shows the timeline, which --no-timeline leaves out: drop one of them")
    kind = view[0] if view else "native"
    require_viewer(kind)
    return kind


def _served(port: int | None) -> AbstractContextManager[LiveRun | None]:
    if port is None:
        return nullcontext()
    require_serve()
    leave_cores_to_helpers()  # before Open3D is loaded
    from app.live.live_run import LiveRun
    from app.server.access_rules import AccessRules

    live = LiveRun(AccessRules("127.0.0.1"), port)
    progress_console().print(f"serving the map while it grows at {live.address}", soft_wrap=True, highlight=False)
    return live


def _go_on_serving(live: LiveRun) -> None:
    if not live.is_alive:
        print_notes(["the server ended during the run: razer serve shows the map again"])
        return
    progress_console().print(f"serving the finished map at {live.address} (Ctrl-C ends it)", highlight=False)
    live.wait()


def _run(
    folder: Path, config: RunConfig, target: RunFolder, vocabulary: str | None, watchers: Watchers = NOBODY
) -> RunResult:
    classes = None if vocabulary is None else read_vocabulary(vocabulary)
    # Late, since Open3D and torch take seconds to load: help and wrong usage should not wait for them.
    leave_cores_to_helpers()
    with waiting_for("starting"):
        from app.frames.cameras.refined_camera import with_camera_of
        from app.frames.open_recording import open_recording
        from app.pipeline.prepare_run import resolve_models
        from app.pipeline.run_pipeline import run_to_folder

    console = progress_console()
    sequence = open_recording(folder, config.input, console)
    noted = with_camera_of(config.input, sequence).model_copy(update={"folder": str(folder.absolute())})
    noted_config = config.model_copy(update={"input": noted})
    if classes is None:
        return run_to_folder(sequence, noted_config, target, console, watchers, is_reopenable=True)
    from app.query.label_run import label_run, require_names

    require_names(resolve_models(config)[0].embedder, classes)
    result = run_to_folder(sequence, noted_config, target, console, watchers, is_reopenable=True, vocabulary=vocabulary)
    with waiting_for("naming the instances"):
        return replace(result, panoptic=label_run(target.final, classes, trust=config.embedder.trust).named())


def _run_both(
    folder: Path,
    out: Path,
    options: RunOptions,
    vocabulary: str | None,
    overwrite: bool,
    json: bool,
    viewer: ViewerKind | None,
) -> int:
    """One run under given poses, one under estimated ones, and their comparison: OUT/given, OUT/slam, OUT/compare; both
    on one timeline, OUT/timeline.rrd."""
    for name in BOTH:
        RunFolder(out / name, overwrite=overwrite)  # before hours are spent on the first
    for name in BOTH:
        progress_console().print(f"mapping under poses: {name}")
        config = replace(options, poses=name, sparse=options.sparse if name == "slam" else None).read()
        result = _run(folder, config, RunFolder(out / name, overwrite=overwrite), vocabulary, Watchers(viewer=viewer))
        if result.exit_code:
            return result.exit_code
    if config.run.timeline:
        from app.timeline.side_by_side import write_side_by_side

        with waiting_for("writing both runs on one timeline"):
            write_side_by_side(out / TIMELINE, [out / name for name in BOTH])
    # What was trusted to make the runs is trusted to compare them.
    _compare_both(folder, out, config.embedder.trust, json)
    return 0


def _compare_both(folder: Path, out: Path, trust: Trust, json: bool) -> None:
    from app.comparison.compare_to_folder import compare_to_folder
    from app.comparison.folder import RECORDING
    from app.comparison.report import report
    from data_tools.truth.open_truth import has_truth
    from razer.metrics.presets import PRESETS

    truth, given, slam = folder if has_truth(folder) else None, out / BOTH[0], out / BOTH[1]
    comparison = compare_to_folder(given, slam, out / "compare", truth=truth, rules=PRESETS["default"], trust=trust)
    print_notes(comparison.notes)
    if json:
        print(dumps(comparison.as_json()))
        return
    report(comparison, result_console(), out / "compare")
    timeline = out / TIMELINE if (out / TIMELINE).exists() else out / "compare" / RECORDING
    print_next(viewing(timeline), looking_at(slam))
