"""`razer query`: open-vocabulary retrieval of instances by text or image, and whether any matches."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.streams import print_notes
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.query.queryable_map import QueryableMap
    from razer.map_object import Answer

_N_HITS = 5


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
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
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
        The part of the image that shows it, as x,y,width,height in pixels.
    min_score:
        Minimum score of a hit, from 0 to 1. Lower: higher recall, lower precision.
    embedder:
        Embedder, a name or module:Class; the one that the run was made with if not given.
    set:
        One setting as section.key=value, such as an option of the embedder; may be repeated.
    render:
        Write a PNG of the map with the hits in colour.
    json:
        One line of JSON.
    """
    _check_arguments(text, k, image, box, min_score, render)
    from app.query.queryable_map import open_queryable_map  # late, since it brings Open3D and torch along

    queryable = open_queryable_map(run, embedder, set, by_text=text is not None, trust=options.trust)
    answer = _shortened(_answer(queryable, text, image, box, min_score), k)
    if render is not None:
        _draw(queryable, answer, render)
    _report(queryable, text if text is not None else str(image), answer, json)
    return 0


def _check_arguments(
    text: str | None, k: int | None, image: Path | None, box: str | None, min_score: float | None, render: Path | None
) -> None:
    if (text is None) == (image is None):
        raise BadInput("give either a text to look for, or a picture with --image")
    if (k is not None and k < 1) or (min_score is not None and not 0 <= min_score <= 1):
        raise BadInput("-k is at least 1, and --min-score from 0 to 1")
    if box is not None and image is None:
        raise BadInput("--box is a part of the picture that --image names")
    if render is not None and not render.absolute().parent.is_dir():
        raise BadInput(f"{render} cannot be written: give a .png in a folder that exists")


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


def _draw(queryable: QueryableMap, answer: Answer, target: Path) -> None:
    import cv2

    from app.render.highlight import highlight_hits

    mesh = queryable.panoptic.mesh_of([hit.object.id for hit in answer.hits])
    picture = highlight_hits(mesh, queryable.up, answer.hits)
    try:
        written = cv2.imwrite(str(target), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    except cv2.error:
        written = False
    if not written:
        raise BadInput(f"{target} cannot be written: give a .png in a folder that exists")


def _report(queryable: QueryableMap, query: str, answer: Answer, json: bool) -> None:
    from app.query.answer import answer_json, print_answer
    from app.query.view_crops import ViewCrops

    crops = ViewCrops(queryable.folder, queryable.config.input) if answer.found else None
    result = answer_json(query, answer, crops)
    print_notes(crops.notes if crops else ())
    if json:
        print(dumps(result))
    else:
        print_answer(result)
