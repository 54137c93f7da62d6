"""Download errors of hub, network and disk as one-line messages."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from huggingface_hub import constants
from huggingface_hub.errors import (  # type: ignore[attr-defined]
    EntryNotFoundError,
    GatedRepoError,
    HfHubHTTPError,
    HTTPError,
    OfflineModeIsEnabled,
    RepositoryNotFoundError,
    RevisionNotFoundError,
)

from razer.errors import BadInput, one_line
from razer.models.hub.cache import cache_folder
from razer.models.hub.catalogue import CatalogueEntry

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT}
_RESUMED = "what came so far is kept, run the command again to go on"


@contextmanager
def as_bad_input(entry: CatalogueEntry) -> Iterator[None]:
    """Errors of the hub, the network and the disk as BadInput; others pass."""
    try:
        yield
    except BadInput:
        raise
    except (HTTPError, OSError) as error:
        raise BadInput(f"{entry.name}: {_line(entry, error)}") from error


def _line(entry: CatalogueEntry, error: Exception) -> str:
    endpoint = constants.ENDPOINT
    if isinstance(error, GatedRepoError):
        return f"{endpoint}/{entry.repo} wants a login: ask for access there, then run 'hf auth login'"
    if isinstance(error, RepositoryNotFoundError | RevisionNotFoundError | EntryNotFoundError):
        return f"{endpoint} has no such file any more ({one_line(error)}); 'razer models list' shows others"
    if isinstance(error, OfflineModeIsEnabled):
        return "not downloaded, and HF_HUB_OFFLINE is set: unset it to download"
    if isinstance(error, HfHubHTTPError):
        return f"{endpoint} answers with an error ({one_line(error)}); {_RESUMED}"
    if isinstance(error, HTTPError):
        return f"{endpoint} cannot be reached ({one_line(error)}): is there a network? {_RESUMED}"
    if isinstance(error, OSError) and error.errno:
        return _disk_line(error)
    return f"the download was cut short ({one_line(error)}); {_RESUMED}"


def _disk_line(error: OSError) -> str:
    if error.errno in _NO_ROOM:
        return f"no room left at {cache_folder()}: free some, or set HF_HOME; {_RESUMED}"
    return f"{cache_folder()} cannot be written: {error.strerror}; set HF_HOME to a folder that can"
