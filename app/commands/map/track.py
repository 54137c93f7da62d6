"""`razer track`: where the camera was, from the images alone; no map."""

from __future__ import annotations

from functools import partial
from json import dumps
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.console.streams import progress_console, result_console
from app.pipeline.interrupt import INTERRUPTED
from app.settings.options import Flag, RecordingOptions
from razer.storage.atomic_files import replace_file


def track(
    folder: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    live_poses: Path | None = None,
    options: RecordingOptions = RecordingOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Estimate the camera's path: odometry, loop closure, smoothing at the end.

    Poses that come with the recording are not used, but errors against them are reported.
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
    settings = options.input_settings()

    # Late, as in `razer run`.
    from app.frames.open_recording import open_unchecked
    from app.pipeline.track_only import tracked_path
    from app.run_folder.save_run import tum_text

    tracked = tracked_path(open_unchecked(folder, settings), settings, progress_console())
    for path, poses in ((out, tracked.final), (live_poses, tracked.live)):
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            text = tum_text([tracked.stamps[index] for index in poses], list(poses.values()))
            replace_file(path, partial(Path.write_text, data=text, encoding="utf-8"))
    content = tracked.as_json()
    if json:
        print(dumps(content))
    else:
        for name, value in content.items():
            result_console().print(f"{name}: {value}", highlight=False, soft_wrap=True)
    return INTERRUPTED if tracked.interrupted else 0
