"""Masks from depth and colour, without weights."""
