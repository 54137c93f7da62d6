"""`razer track`: where the camera was, from the images alone; no map."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, ExitStack
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import mapping
from app.pipeline.interrupt import INTERRUPTED
from app.pipeline.open_stretches import print_open
from app.run_folder.folder_lock import writing
from app.settings.options import Flag, TrackOptions
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content

if TYPE_CHECKING:
    from app.pipeline.track_only import TrackedPath
    from app.settings.run_config import RunConfig

MIN_LOCATED = 0.5  # share of the frames: with fewer a map is not worth making


def track(
    folder: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    live_poses: Path | None = None,
    options: TrackOptions = TrackOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Estimate the camera's path: odometry, loop closure, smoothing at the end.

    Poses that come with the recording are not used, but errors against them are reported; --poses refine corrects them.
    Ctrl-C smooths and writes what was tracked until then; the exit code is 130.

    Parameters
    ----------
    folder:
        The recording; its layout is recognised.
    out:
        A TUM file for the final, smoothed poses: 'stamp tx ty tz qx qy qz qw', world from camera; the world is the
        first camera.
    live_poses:
        A TUM file for the poses as they were known at each frame.
    json:
        One line of JSON.
    """
    config = options.read()

    with ExitStack() as files:
        for path in dict.fromkeys([out, live_poses]):
            if path is not None:
                files.enter_context(_written(path))
        tracked = _tracked(folder, config)
        for path, poses in ((out, tracked.final), (live_poses, tracked.live)):
            if path is not None:
                replace_content(path, tracked.tum_text(poses))
    if json:
        print(dumps(tracked.as_json()))
    else:
        _report(tracked, out, live_poses)
    if tracked.interrupted:
        n_seen = len(tracked.stamps) + len(tracked.skipped)
        print(f"razer: interrupted after {n_seen} of {tracked.n_asked} frames", file=sys.stderr)
        return INTERRUPTED
    if not json:
        _advise(tracked, folder, options)
    return 0


def _tracked(folder: Path, config: RunConfig) -> TrackedPath:
    # Late, as in `razer run`.
    with waiting_for("starting"):
        from app.frames.open_recording import open_noted, open_recording
        from app.pipeline.track_only import tracked_path

    # Poses that are corrected are checked; with others the path is only compared.
    opened = open_recording if config.input.poses == "refine" else open_noted
    return tracked_path(opened(folder, config.input, progress_console()), config, progress_console())


def _advise(tracked: TrackedPath, folder: Path, options: TrackOptions) -> None:
    choice = "both" if tracked.given else "slam"  # both compares them
    words = options.words() if options.poses else ("--poses", choice, *options.words())
    is_worth_it = len(tracked.final) >= MIN_LOCATED * len(tracked.stamps)
    print_next(mapping(folder, *words) if is_worth_it else ("inspect", folder))


def _written(path: Path) -> AbstractContextManager[None]:
    if path.is_dir():
        raise BadInput(f"{path} is a folder: give a file for the poses")
    return writing(path)


def _report(tracked: TrackedPath, out: Path | None, live_poses: Path | None) -> None:
    console = result_console()
    corrections = tracked.corrections()
    lines = tracked.as_json() | ({} if corrections is None else {"corrected": corrections.describe()})
    del lines["open"]
    for name, value in lines.items():
        console.print(f"{name}: {value}", highlight=False, soft_wrap=True)
    print_open(tracked.open, console)
    for path, about in ((out, "the smoothed path"), (live_poses, "poses as they were known at each frame")):
        if path is not None:
            console.print(f"output: {path}: {about}, stamp tx ty tz qx qy qz qw", soft_wrap=True)
