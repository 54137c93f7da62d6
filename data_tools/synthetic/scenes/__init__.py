"""Whole scenes: a layout, its things and a walk."""
