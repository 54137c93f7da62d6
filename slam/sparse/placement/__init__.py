"""Placement: where pictures lie in front of each other, and which of them lie together."""
