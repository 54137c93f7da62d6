"""Checks of a recording before it is mapped: poses, depth scale, alignment of colour and depth."""
