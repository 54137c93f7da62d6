"""`razer library`: the instances of many maps in one table, searched by text, by picture or by an instance."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from app.console.outputs import print_next
from app.console.streams import result_console
from app.console.waiting import waiting_for
from app.library.search_options import SearchOptions
from app.settings.extra_libraries import require_library
from app.settings.options import Flag, TrustOptions
from app.verbs import named

if TYPE_CHECKING:
    from app.library.add_run import Added

FORMAT = 1
Uri = Annotated[str, Parameter(name="--library")]


def add(
    runs: Path, /, *more: Path, library: Uri, scene: str | None = None, thumbnails: bool = True, json: Flag = False
) -> None:
    """Add the maps of runs, each in the place of what the library has of that run.

    Parameters
    ----------
    runs:
        The folder of a finished run, or of a saved map.
    more:
        Further ones.
    library:
        Where it lies: a folder, or s3://BUCKET/PATH; made if it is not there.
    scene:
        What the place is called, where runs of the same place belong together; the recording's name if not given.
    thumbnails:
        Keep a small picture of the best view of each instance, too.
    json:
        One line of JSON.
    """
    require_library()
    added: list[Added] = []
    try:
        with waiting_for("adding maps"):
            from app.library.add_run import add_runs

            added += add_runs((runs, *more), library, scene, with_thumbnails=thumbnails)
    finally:  # what is in the library is told, also where a later run cannot be added
        if added:
            _tell_added(added, json)
    if not json:
        print_next(("library", "query", "a chair", "--library", library))


def _tell_added(added: list[Added], json: bool) -> None:
    if json:
        print(dumps({"format": FORMAT, "added": [vars(each) for each in added]}))
        return
    for each in added:
        result_console().print(f"{each.run}: {each.n_instances} instances of scene {each.scene}", soft_wrap=True)


def query(
    text: str | None = None,
    /,
    *,
    library: Uri,
    search: SearchOptions = SearchOptions(),  # noqa: B008
    by_scene: Flag = False,
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> None:
    """Find instances in all maps; what is in none of them is reported as not found.

    Parameters
    ----------
    text:
        What to look for, such as "a red chair with wheels".
    library:
        Where it lies.
    by_scene:
        Group the hits by scene.
    json:
        One line of JSON.
    """
    require_library()
    search.check(text)
    with waiting_for("searching the library"):
        from app.library.answer import answer_json, print_answer  # late, as in `razer query`
        from app.library.ask import ask

        answer = ask(library, text, search, options.trust)
        result = answer_json(text or search.like or str(search.image), answer, by_scene=by_scene)
    if json:
        print(dumps(result))
        return
    print_answer(result)
    if answer.hits:
        print_next(("view", answer.hits[0].run, "--page", "map.html"))


def list_maps(*, library: Uri, json: Flag = False) -> None:
    """List the maps of a library.

    Parameters
    ----------
    library:
        Where it lies.
    json:
        One line of JSON.
    """
    require_library()
    with waiting_for("reading the library"):
        from app.library.report import map_list, print_maps

        maps = map_list(library)
    if json:
        print(dumps({"format": FORMAT, "maps": maps}))
    else:
        print_maps(maps)


def remove(run: str, /, *more: str, library: Uri, json: Flag = False) -> None:
    """Remove the maps of runs from a library; the runs stay.

    Parameters
    ----------
    run:
        A run, as `razer library list` has it, or its folder.
    more:
        Further ones.
    library:
        Where it lies.
    json:
        One line of JSON.
    """
    require_library()
    with waiting_for("removing maps"):
        from app.library.report import remove_runs

        removed = remove_runs((run, *more), library)
    if json:
        print(dumps({"format": FORMAT, "removed": removed}))
        return
    for each in removed:
        result_console().print(f"removed {each}", soft_wrap=True)
    print_next(("library", "compact", "--library", library))


def compact(*, library: Uri, json: Flag = False) -> None:
    """Write small files together, index what is new, and remove versions older than ten minutes; readers go on.

    Parameters
    ----------
    library:
        Where it lies.
    json:
        One line of JSON.
    """
    require_library()
    with waiting_for("compacting the library"):
        from app.library.report import compacted

        result = compacted(library)
    _show_stats(result, json)


def stats(*, library: Uri, json: Flag = False) -> None:
    """Show how many maps and instances there are, of which models, and how large the library is.

    Parameters
    ----------
    library:
        Where it lies.
    json:
        One line of JSON.
    """
    require_library()
    with waiting_for("reading the library"):
        from app.library.report import library_stats

        result = library_stats(library)
    _show_stats(result, json)


def _show_stats(result: dict, json: bool) -> None:
    from app.library.report import print_stats

    if json:
        print(dumps({"format": FORMAT, **result}))
    else:
        print_stats(result)


verb = App(name="library", help_format="markdown", help_epilogue=named("library").epilogue)
for _function, _name in (
    (add, "add"),
    (query, "query"),
    (list_maps, "list"),
    (remove, "remove"),
    (compact, "compact"),
    (stats, "stats"),
):
    verb.command(_function, name=_name)
