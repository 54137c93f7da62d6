"""Loaded by every Python process that has this folder on PYTHONPATH: refuses what leaves this machine, and logs it.

$NO_NETWORK_LOG is the file that each try is a line of.
"""

import ipaddress
import os
import sys
import traceback

_NAMES = {"", "localhost", os.uname().nodename}
_WITH_ADDRESS = {"socket.connect": 1, "socket.sendto": 1, "socket.sendmsg": 1, "socket.getaddrinfo": 0}
_WITH_ADDRESS |= {"socket.gethostbyname": 0, "socket.gethostbyaddr": 0}


def _stays_here(address: object) -> bool:
    host = address[0] if isinstance(address, tuple) and address else address
    host = host.decode() if isinstance(host, bytes) else host
    if not isinstance(host, str) or host in _NAMES or host.startswith("/"):
        return True  # no address, this machine, or a Unix socket
    try:
        found = ipaddress.ip_address(host)
    except ValueError:
        return False  # a name to look up
    return found.is_loopback or found.is_unspecified


def _refuse(event: str, arguments: tuple) -> None:
    if event in _WITH_ADDRESS and not _stays_here(arguments[_WITH_ADDRESS[event]]):
        where = " < ".join(f"{frame.filename}:{frame.lineno}" for frame in reversed(traceback.extract_stack(limit=12)))
        with open(os.environ["NO_NETWORK_LOG"], "a") as log:
            log.write(f"{event} {arguments[_WITH_ADDRESS[event]]} by {sys.argv}: {where}\n")
        raise OSError(f"{event} is refused here")


sys.addaudithook(_refuse)
