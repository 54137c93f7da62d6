"""`razer query`: open-vocabulary retrieval of instances by text or image, and whether any matches."""

from __future__ import annotations

from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import print_notes, progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import serving
from app.run_folder.folder_lock import require_writable
from app.settings.options import Assignments, Flag, TrustOptions
from app.settings.picture_options import PictureOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.pictures.view import View
    from app.query.queryable_map import QueryableMap
    from razer.map_object import Answer

PICTURE = "query.png"
_N_HITS = 5
_SIZE = (640, 480)  # of a picture that nobody asked for: it should not cost more than the answer


def query(
    run: Path,
    text: str | None = None,
    /,
    *,
    k: Annotated[int | None, Parameter(name=["-k"])] = None,
    image: Path | None = None,
    box: str | None = None,
    min_score: float | None = None,
    embedder: str | None = None,
    set: Assignments = (),
    render: Path | None = None,
    picture: PictureOptions = PictureOptions(),  # noqa: B008
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> None:
    """Find instances by text or by image; what is not in the map is reported as not found.

    Parameters
    ----------
    run:
        The folder of a finished run.
    text:
        What to look for, such as "a red chair"; kinds and purposes, too: furniture, "something to sit on".
    k:
        Maximum number of hits; 5 if not given, and no limit where a kind or a purpose was asked for by names.
    image:
        An image of what to look for, instead of a text.
    box:
        The part of it that counts, as x,y,width,height in pixels.
    min_score:
        Minimum score of a hit, from 0 to 1. Lower: higher recall, lower precision.
    embedder:
        Embedder, a name or module:Class; the one that the run was made with if not given.
    set:
        One setting as section.key=value, such as an embedder's option; may be repeated.
    render:
        Where the picture of the map with the hits in colour goes; RUN/query.png if not given, none with --json.
    json:
        One line of JSON.
    """
    _check_arguments(text, k, image, box, min_score)
    view = _checked_view(picture, render)
    with waiting_for("opening the map and looking for it"):
        from app.query.queryable_map import open_queryable_map  # late: models may bring torch along

        queryable = open_queryable_map(run, embedder, set, by_text=text is not None, trust=options.trust)
        answer = _shortened(_answer(queryable, text, image, box, min_score), k)
    _deliver(queryable, text or str(image), answer, render, view, json)


def _deliver(queryable: QueryableMap, query: str, answer: Answer, render: Path | None, view: View, json: bool) -> None:
    """Print the answer, draw it where that is wanted, and say what to do next."""
    _report(queryable, query, answer, json)
    if render is not None or (answer.found and not json):
        _draw(queryable, answer, render, view, json)
    if not json:
        print_next(("view", queryable.folder, "--page", queryable.folder / "map.html"), *serving(queryable.folder))


def _checked_view(options: PictureOptions, target: Path | None) -> View:
    """How the answer is drawn; raises BadInput where it cannot be, before anything is asked."""
    view = options.view()
    if target is not None:
        from app.pictures.picture_file import check_picture_path

        check_picture_path(target, view)
        require_writable(target)
    return view


def _check_arguments(
    text: str | None, k: int | None, image: Path | None, box: str | None, min_score: float | None
) -> None:
    if (text is None) == (image is None):
        raise BadInput("give either a text to look for, or a picture with --image")
    if (k is not None and k < 1) or (min_score is not None and not 0 <= min_score <= 1):
        raise BadInput("-k is at least 1, and --min-score from 0 to 1")
    if box is not None and image is None:
        raise BadInput("--box is a part of the picture that --image names")


def _answer(
    queryable: QueryableMap, text: str | None, image: Path | None, box: str | None, min_score: float | None
) -> Answer:
    from app.query.query_image import embed_query_image
    from razer.query.ranking import PRESENT

    threshold = PRESENT if min_score is None else min_score
    if text is not None:
        return queryable.panoptic.query(text, threshold)
    assert image is not None
    vector = embed_query_image(queryable.embedder, queryable.config.embedder.name, image, box)
    return queryable.panoptic.query_image(vector, threshold)


def _shortened(answer: Answer, k: int | None) -> Answer:
    """The best k hits; of those of a kind all, if k is not given: who asks for chairs and couches wants each."""
    by_kind = any(hit.through for hit in answer.hits)
    return answer if k is None and by_kind else answer.best(k or _N_HITS)


def _draw(queryable: QueryableMap, answer: Answer, target: Path | None, view: View, json: bool) -> None:
    from app.pictures.picture_file import add_picture, write_view
    from app.pictures.scenes import answer_scene

    with waiting_for("drawing the answer"):
        scene = answer_scene(queryable.panoptic, answer.hits)
        if target is None:
            small = replace(view, size=view.size or _SIZE)
            add_picture(queryable.folder / PICTURE, scene, result_console(), small)
        else:
            write_view(target, scene, view, progress_console() if json else result_console())


def _report(queryable: QueryableMap, query: str, answer: Answer, json: bool) -> None:
    from app.query.answer import answer_json, print_answer
    from app.query.view_crops import ViewCrops

    with waiting_for("cutting pictures of what was found"):
        crops = ViewCrops(queryable.folder, queryable.config.input) if answer.found else None
        result = answer_json(query, answer, crops)
    print_notes(crops.notes if crops else ())
    if json:
        print(dumps(result))
    else:
        print_answer(result)
