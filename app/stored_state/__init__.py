"""State of a process in files, from which another process goes on: what pickle does, for classes known beforehand."""
