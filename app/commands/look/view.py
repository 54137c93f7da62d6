"""`razer view`: a finished run in the Rerun viewer, or as an image."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from app.console.streams import print_notes
from app.run_folder.run_folder import TIMELINE
from app.settings.options import Flag
from razer.errors import BadInput


def view(
    run: Path, other: Path | None = None, /, *, web: Flag = False, picture: Path | None = None, page: Path | None = None
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
        Write a PNG of the map, in its colours and by instance with names, instead of opening the viewer.
    page:
        Write one HTML file that shows the map in any browser, offline, to turn, search and click on.
    """
    if page is not None:
        return _write_page(run, page)
    if picture is not None:
        return _draw(run, picture)

    # Late, as in `razer run`.
    from app.timeline.viewer.rerun_viewer import open_viewer, require_display

    if other is None:
        return open_viewer(run, web)
    if not web:
        require_display()  # before both are read
    from app.timeline.side_by_side import write_side_by_side

    with TemporaryDirectory(prefix="razer-view-") as folder:
        both = Path(folder) / TIMELINE
        write_side_by_side(both, [run, other])
        return open_viewer(both, web)


def _draw(run: Path, target: Path) -> None:
    # Late, as in `razer run`.
    import cv2

    from app.render.name_tags import names_by_size
    from app.render.overview_image import overview_image
    from razer.saved_map import load_map

    panoptic = load_map(run)
    print_notes(panoptic.edit_problems)
    image = overview_image(panoptic.mesh, panoptic.up_or_z, names=names_by_size(panoptic.objects))
    if not target.parent.is_dir() or not cv2.imwrite(str(target), image[..., ::-1]):
        raise BadInput(f"{target} cannot be written: give a .png in a folder that exists")


def _write_page(run: Path, target: Path) -> None:
    # Late, as in `razer run`.
    from app.console.streams import result_console
    from app.page.write_page import write_page

    n_bytes = write_page(run, target)
    result_console().print(f"{target}: {n_bytes / 1e6:.1f} MB, open it in a browser", soft_wrap=True)
