"""`razer serve`: a map as a page in the browser and as an interface for programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.settings.extra_libraries import require_library, require_serve
from app.settings.options import DEFAULT_PORT, TrustOptions
from razer.errors import BadInput


def serve(
    run: Path | None = None,
    /,
    *,
    library: str | None = None,
    port: int = DEFAULT_PORT,
    host: str = "127.0.0.1",
    token: Annotated[str | None, Parameter(env_var="RAZER_TOKEN")] = None,
    options: TrustOptions = TrustOptions(),  # noqa: B008
) -> None:
    """Show a map in the browser, with live queries and edits, and answer programs under /api/v1.

    Ctrl-C ends it.

    Parameters
    ----------
    run:
        The folder of a finished run, or of a saved map.
    library:
        A library of maps instead: a page to search it, from which hits open their maps.
    port:
        Where to listen; 0: any free port.
    host:
        Address to listen on. By default only this machine gets in; any other needs a token.
    token:
        What whoever asks must know, 16 characters or more; the page is opened with /?token=TOKEN.
    """
    require_serve()
    if (run is None) == (library is None):
        raise BadInput("give the folder of a run to serve, or a library of maps with --library")
    from app.server.access_rules import AccessRules  # late, as in `razer run`

    rules = AccessRules(host, token)
    if library is not None:
        require_library()
        from app.server.serve_library import serve_library

        serve_library(library, rules, port, options.trust)
        return
    assert run is not None
    from app.server.serve_run import serve_run

    serve_run(run, rules, port, options.trust)
