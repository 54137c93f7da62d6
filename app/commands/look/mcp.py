"""`razer mcp`: a map as tools for agents."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.settings.extra_libraries import require_library, require_serve
from app.settings.options import Flag, TrustOptions
from razer.errors import BadInput


def mcp(
    run: Path | None = None,
    /,
    *,
    library: str | None = None,
    allow_edits: Flag = False,
    http: int | None = None,
    host: str = "127.0.0.1",
    token: Annotated[str | None, Parameter(env_var="RAZER_TOKEN")] = None,
    options: TrustOptions = TrustOptions(),  # noqa: B008
) -> None:
    """Offer a map as tools for agents (Model Context Protocol), over standard input and output.

    Parameters
    ----------
    run:
        The folder of a finished run, or of a saved map.
    library:
        A library of maps to search, instead of a run or beside it.
    allow_edits:
        Tools that change the map, too: rename, relabel, merge, split, delete, undo, redo.
    http:
        Port for streamable HTTP instead, at /mcp; 0: any free one.
    host:
        Address to listen on with --http. By default only this machine gets in; any other needs a token.
    token:
        With --http, what each request must bring as Authorization: Bearer, 16 characters or more.
    """
    require_serve()
    if run is None and library is None:
        raise BadInput("give the folder of a run, or a library of maps with --library")
    if run is None and allow_edits:
        raise BadInput("--allow-edits is for the map of a run: a library is only searched")
    if library is not None:
        require_library()
    from app.agents.serve_agents import Offered, serve_http, serve_stdio  # late, as in `razer run`
    from app.server.access_rules import AccessRules

    offered = Offered(run, library, options.trust, allow_edits)
    if http is None:
        serve_stdio(offered)
    else:
        serve_http(offered, AccessRules(host, token), http)
