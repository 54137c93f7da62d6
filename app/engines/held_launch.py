"""Start of a run that ends with whoever started it, held to some cores; a script, so that it takes milliseconds.

    python -S held_launch.py PARENT CORES COMMAND ...

The kernel kills the process when its parent is gone (PR_SET_PDEATHSIG), so that no worker that dies leaves a run behind
that goes on writing beside its second attempt. Cores are taken by locks on files, one a core, which all engines on a
machine share and which go with the process.
"""

import ctypes
import fcntl
import os
import signal
import sys
import tempfile
import time

PR_SET_PDEATHSIG = 1
POLL_S = 0.2


def take_cores(count: int) -> None:
    """Wait for so many cores that nobody else has taken, and run on them alone."""
    folder = os.path.join(tempfile.gettempdir(), f"razer-cores-{os.getuid()}")
    os.makedirs(folder, mode=0o700, exist_ok=True)
    cores = sorted(os.sched_getaffinity(0))
    taken: set[int] = set()
    while len(taken) < min(count, len(cores)):
        for core in cores:
            if core not in taken and len(taken) < count and _locked(os.path.join(folder, str(core))):
                taken.add(core)
        if len(taken) < min(count, len(cores)):
            time.sleep(POLL_S)
    os.sched_setaffinity(0, taken)


def _locked(path: str) -> bool:
    file = os.open(path, os.O_CREAT | os.O_RDWR | os.O_NOFOLLOW, 0o600)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        return False
    os.set_inheritable(file, True)  # the lock is the run's from now on
    return True


def main() -> None:
    """Become the command."""
    parent, cores, command = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit(1)  # it was gone before
    if cores:
        take_cores(cores)
    os.execv(command[0], command)


if __name__ == "__main__":
    main()
