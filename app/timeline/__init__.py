"""The Rerun recording of a run, and looking at it."""
