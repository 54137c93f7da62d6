"""A map that is served while it grows: snapshots from the run, and the process that answers from them."""
