"""`razer view`: a finished run in the Rerun viewer, or as an image."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from app.console.outputs import print_next
from app.console.streams import print_notes, result_console
from app.console.waiting import waiting_for
from app.next_steps import serving
from app.pictures.view import Style
from app.run_folder.folder_lock import require_writable
from app.run_folder.run_folder import TIMELINE
from app.settings.options import Flag
from app.settings.picture_options import PictureOptions
from razer.errors import BadInput


def view(
    run: Path,
    other: Path | None = None,
    /,
    *,
    web: Flag = False,
    picture: Path | None = None,
    style: Style | None = None,
    query: str | None = None,
    view_options: PictureOptions = PictureOptions(),  # noqa: B008
    page: Path | None = None,
) -> None:
    """Open the timeline of a run in the Rerun viewer, render its map to an image, or write it as a page to click on.

    A run that is still going on is shown as it goes on. Two runs are shown side by side, on one axis of frames.

    Parameters
    ----------
    run:
        The folder of a run, or a Rerun recording (.rrd), such as the compare.rrd of `razer compare`.
    other:
        A second run, to be shown beside the first.
    web:
        In the browser instead of the native viewer.
    picture:
        Write a PNG of the map, with the names of its largest things, instead of opening the viewer.
    style:
        Of the picture: color, as the camera saw it; instance or class, each in a colour of its own; query, what a text
        means. By instance if not given.
    query:
        The text of the style query.
    page:
        Write one HTML file that shows the map in any browser, offline, to turn, search and click on.
    """
    if page is not None:
        return _write_page(run, page)
    if picture is not None:
        return _draw(run, picture, style or ("query" if query else "instance"), query, view_options)
    if style is not None or query is not None or view_options != PictureOptions():
        raise BadInput("--style, --query, --angle, --size and --background are of a picture: add --picture FILE.png")

    return _open(run, other, web)


def _open(run: Path, other: Path | None, web: bool) -> None:
    # Late, as in `razer run`.
    from app.timeline.viewer.rerun_viewer import open_viewer, require_display

    if other is None:
        return open_viewer(run, web)
    if not web:
        require_display()  # before both are read
    from app.timeline.side_by_side import write_side_by_side

    with TemporaryDirectory(prefix="razer-view-") as folder:
        both = Path(folder) / TIMELINE
        with waiting_for("writing both runs on one timeline"):
            write_side_by_side(both, [run, other])
        return open_viewer(both, web)


def _draw(run: Path, target: Path, style: Style, text: str | None, options: PictureOptions) -> None:
    if (style == "query") != (text is not None):
        raise BadInput("--style query shows what --query TEXT means: give both, or neither")
    with waiting_for("starting"):
        from app.pictures.picture_file import check_picture_path, write_view  # late, as in `razer run`
        from app.pictures.scenes import answer_scene, map_scene
        from razer.saved_map import load_map

    view = options.view()
    check_picture_path(target, view)
    require_writable(target)
    with waiting_for("opening the map"):
        panoptic = load_map(run)
    print_notes(panoptic.edit_problems)
    with waiting_for("drawing the map"):
        scene = map_scene(panoptic, style) if text is None else answer_scene(panoptic, panoptic.query(text).hits)
        write_view(target, scene, view, result_console())
    print_next(("view", run, "--page", run / "map.html"), *serving(run))


def _write_page(run: Path, target: Path) -> None:
    with waiting_for("starting"):
        from app.page.write_page import write_page  # late, as in `razer run`

    with waiting_for("making the page: its surface, its pictures", at_once=True):
        n_bytes = write_page(run, target)
    result_console().print(f"{target}: {n_bytes / 1e6:.1f} MB, open it in a browser", soft_wrap=True)
    print_next(("view", run, "--picture", run / "map.png"), *serving(run))
