"""The Rerun recording of a run, and the viewer of it."""
