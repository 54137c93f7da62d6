"""Checks of two views that were placed to each other: what stands where the other saw through, and colours."""
