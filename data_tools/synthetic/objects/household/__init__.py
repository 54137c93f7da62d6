"""Small things, one maker per class."""
