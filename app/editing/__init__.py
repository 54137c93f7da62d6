"""Hand edits of a run from the command line."""
