"""`razer query`: which instances of a map a text or a picture means, and whether any does."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.console.streams import progress_console
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.query.queryable_map import QueryableMap
    from razer.map_object import Answer


def query(
    run: Path,
    text: str | None = None,
    /,
    *,
    k: Annotated[int, Parameter(name=["-k"])] = 5,
    image: Path | None = None,
    box: str | None = None,
    min_score: float | None = None,
    embedder: str | None = None,
    set: Assignments = (),
    render: Path | None = None,
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Find instances by words or by a picture; what is not in the map is said to be not there.

    Parameters
    ----------
    run:
        The folder of a finished run.
    text:
        What to look for, such as "a red chair".
    k:
        Most hits to tell.
    image:
        A picture of what to look for, instead of a text.
    box:
        The part of the picture that shows it, as x,y,width,height in pixels.
    min_score:
        What an instance has to score to count; from 0 to 1. Lower: less is missed, more is wrong.
    embedder:
        A name or module:Class, if not the embedder that the run was made with.
    set:
        One setting as section.key=value, such as an option of the embedder; may be repeated.
    render:
        Write a PNG of the map with the hits in colour.
    json:
        One line of JSON.
    """
    _refuse_nonsense(text, k, image, box, min_score, render)

    # Late, since these bring Open3D and torch along.
    from app.query.answer import answer_json, print_answer
    from app.query.queryable_map import open_queryable_map
    from app.query.view_crops import BestFrames

    asked = open_queryable_map(run, embedder, set, by_text=text is not None, trust=options.trust)
    answer = _answer(asked, text, image, box, min_score).best(k)
    if render is not None:
        _draw(asked, answer, render)
    frames = BestFrames(run, asked.config.input) if answer.found else None
    result = answer_json(text if text is not None else str(image), answer, frames)
    for note in frames.notes if frames else ():
        progress_console().print(f"note: {note}", soft_wrap=True)
    if json:
        print(dumps(result))
    else:
        print_answer(result)
    return 0


def _refuse_nonsense(
    text: str | None, k: int, image: Path | None, box: str | None, min_score: float | None, render: Path | None
) -> None:
    if (text is None) == (image is None):
        raise BadInput("give either a text to look for, or a picture with --image")
    if k < 1 or (min_score is not None and not 0 <= min_score <= 1):
        raise BadInput("-k is at least 1, and --min-score from 0 to 1")
    if box is not None and image is None:
        raise BadInput("--box is a part of the picture that --image names")
    if render is not None and not render.absolute().parent.is_dir():
        raise BadInput(f"{render} cannot be written: give a .png in a folder that exists")


def _answer(
    asked: QueryableMap, text: str | None, image: Path | None, box: str | None, min_score: float | None
) -> Answer:
    from app.query.query_image import embed_picture
    from razer.query.ranking import PRESENT

    threshold = PRESENT if min_score is None else min_score
    if text is not None:
        return asked.panoptic.query(text, threshold)
    assert image is not None
    vector = embed_picture(asked.embedder, asked.config.embedder.name, image, box)
    return asked.panoptic.query_image(vector, threshold)


def _draw(asked: QueryableMap, answer: Answer, target: Path) -> None:
    import cv2

    from app.render.highlight import highlight_hits

    picture = highlight_hits(asked.panoptic.mesh, asked.up, answer.hits)
    try:
        written = cv2.imwrite(str(target), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    except cv2.error:
        written = False
    if not written:
        raise BadInput(f"{target} cannot be written: give a .png in a folder that exists")
