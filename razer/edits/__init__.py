"""Hand edits of a map: typed, logged beside it, applied whenever it is opened."""
