"""Who may ask a server: by the name it is called by, the page that a request comes from, and the token."""

from __future__ import annotations

import hmac
import ipaddress
import re
import socket
from dataclasses import dataclass
from urllib.parse import urlsplit

from razer.errors import BadInput

LEAST_TOKEN = 16  # characters: what is shorter can be guessed
COOKIE = "razer_token"
_TOKEN = re.compile(r"[A-Za-z0-9._~+/=-]+")
_HOST = re.compile(r"(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9.-]+)(:\d{1,5})?")
_LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})


@dataclass(frozen=True)
class AccessRules:
    """host: what the server listens on; token: what requests must bring, None = nothing."""

    host: str
    token: str | None = None

    def __post_init__(self) -> None:
        if self.token is None and not is_loopback(self.host):
            raise BadInput(
                f"--host {self.host} lets other machines in: give them a --token of {LEAST_TOKEN} characters or more"
            )
        if self.token is not None and (len(self.token) < LEAST_TOKEN or not _TOKEN.fullmatch(self.token)):
            raise BadInput(f"--token: give {LEAST_TOKEN} or more of the characters a-z, A-Z, 0-9 and ._~+/=-")

    def knows_host(self, host_header: str) -> bool:
        """Whether a Host header names this server. What resolves to it under a foreign name (DNS rebinding) does not;
        an address cannot be rebound. Ports may differ, as they do behind a tunnel."""
        if not (match := _HOST.fullmatch(host_header)):
            return False
        name = match[1].strip("[]").lower()
        if is_loopback(self.host):
            return name in _LOOPBACK_NAMES
        own = {self.host.lower(), socket.gethostname().lower(), socket.getfqdn().lower(), *_LOOPBACK_NAMES}
        return name in own or _is_address(name)

    def knows_origin(self, origin_header: str, host_header: str) -> bool:
        """Whether a request comes from a page of this server."""
        parts = urlsplit(origin_header)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host_header.lower()

    def admits(self, token: str | None) -> bool:
        """Whether a token is the right one, or none is asked for; takes as long for any."""
        if self.token is None:
            return True
        return hmac.compare_digest((token or "").encode("utf-8", "replace"), self.token.encode())


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches what listens on a host."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
