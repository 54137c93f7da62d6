"""Verbs that make maps and paths: run, track, demo."""
