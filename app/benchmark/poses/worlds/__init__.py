"""Walks that are hard for pose estimation: rendered ones, and those through a recording."""
